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

layout(location = TARGET_OUTPUT) out vec4 target_output;

void main() {
    Fragment fragment = surface_at_fragment();
    vec3 light = indirect_light(fragment);
    if (fragment.surface.lit) {
        light += unlisted_light(fragment.surface);
    }
    target_output = vec4(light * (frame.exposure * frame.light_scale), 1.0);
}
