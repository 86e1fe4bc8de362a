#version 450
// Lights a material's surface as it is drawn, and writes it to the output.
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "frame.glsl"
#include "pixel.glsl"
#include "gbuffer/surface.glsl"
#include "brdf.glsl"
#include "fragment.glsl"
#include "light/direct.glsl"
#include "fog.glsl"
#include "tonemap.glsl"

layout(location = TARGET_OUTPUT) out vec4 target_output;

void main() {
    Fragment fragment = surface_at_fragment();
    Surface surface = fragment.surface;
    vec3 light = indirect_light(fragment);
    light += complete(direct_light(surface, view_direction_world()), surface);
    // The fragment's light is complete.
    vec3 exposed_light = light * frame.exposure;
    if (FOG) {
        exposed_light = fogged(exposed_light, surface.position_world);
    }
    target_output = output_color(exposed_light);
}
