#version 450
// From the light target to the output. Where fog comes between, depth says how much.
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "frame.glsl"
#include "pixel.glsl"
#include "fog.glsl"
#include "tonemap.glsl"

layout(set = SET_INPUTS, binding = INPUT_LIGHT, input_attachment_index = INPUT_LIGHT)
    uniform subpassInput input_light;
layout(set = SET_INPUTS, binding = INPUT_FOG_DEPTH, input_attachment_index = INPUT_FOG_DEPTH)
    uniform subpassInput input_fog_depth;

layout(location = TARGET_OUTPUT) out vec4 target_output;

void main() {
    // Surfaces write alpha 1, and lights add 0 to it.
    vec4 light = subpassLoad(input_light);
    bool is_background = light.a == 0.0;
    vec3 exposed_light = light.rgb / frame.light_scale;
    if (FOG && !is_background) {
        exposed_light = fogged(exposed_light, position_world(subpassLoad(input_fog_depth).r));
    }
    target_output = BACKGROUND && is_background ? background_color() : output_color(exposed_light);
}
