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
#include "tonemap.glsl"

layout(location = TARGET_OUTPUT) out vec4 target_output;

void main() {
    Fragment fragment = surface_at_fragment();
    Surface surface = fragment.surface;
    vec3 light = indirect_light(fragment);
    light += direct_light(surface, position_world(surface.depth), view_direction_world());
    // The fragment's light is complete.
    target_output = output_color(light * frame.exposure);
}
