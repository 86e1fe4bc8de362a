#version 450
// Writes the light that leaves a surface without the listed lights to the light target; they are added one by one
// (light.frag).
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "frame.glsl"
#include "pixel.glsl"
#include "gbuffer/surface.glsl"
#include "brdf.glsl"
#include "fragment.glsl"
#include "light/direct.glsl"
#include "fog.glsl"

layout(location = TARGET_LIGHT) out vec4 target_light;

void main() {
    Fragment fragment = surface_at_fragment();
    vec3 light = indirect_light(fragment);
    if (fragment.surface.lit) {
        light += complete(unlisted_light(fragment.surface), fragment.surface);
    }
    vec3 exposed_light = light * frame.exposure;
    if (FOG) {
        exposed_light = fogged(exposed_light, fragment.surface.position_world);
    }
    target_light = vec4(exposed_light * frame.light_scale, 1.0);
}
