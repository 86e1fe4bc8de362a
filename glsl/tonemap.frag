#version 450
// From the light target to the output.
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "frame.glsl"
#include "tonemap.glsl"

layout(set = SET_INPUTS, binding = INPUT_LIGHT, input_attachment_index = INPUT_LIGHT)
    uniform subpassInput input_light;

layout(location = TARGET_OUTPUT) out vec4 target_output;

void main() {
    target_output = output_color(subpassLoad(input_light).rgb / frame.light_scale);
}
