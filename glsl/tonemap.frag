#version 450
// From the light target, or what the G-buffer holds of light (LIGHT_READ), to the output. What fog and separate diffuse light
// need is read from the G-buffer.
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "frame.glsl"
#include "pixel.glsl"
#include "gbuffer.glsl"
#include "fog.glsl"
#define ALL_PIXELS
#include "tonemap.glsl"

layout(constant_id = ID_LIGHT_ALPHA) const bool LIGHT_ALPHA = true; // else depth tells surfaces from the background

layout(set = SET_INPUTS, binding = INPUT_LIGHT, input_attachment_index = INPUT_LIGHT)
    uniform subpassInput input_light;
layout(set = SET_INPUTS, binding = INPUT_SPECULAR_LIGHT, input_attachment_index = INPUT_SPECULAR_LIGHT)
    uniform subpassInput input_specular_light;

layout(location = TARGET_OUTPUT) out vec4 target_output;

void main() {
    vec4 light = LIGHT_READ ? gbuffer_read_light(FOG || BACKGROUND) : subpassLoad(input_light);
    if (SPLIT_LIGHT) {
        light = vec4(light.rgb * gbuffer_read().diffuse, 0.0) + subpassLoad(input_specular_light);
    }
    // Surfaces write alpha 1, and lights add 0 to it.
    bool is_background = (LIGHT_ALPHA ? light.a : subpassLoad(input_depth).r) == 0.0;
    vec3 exposed_light = light.rgb / frame.light_scale;
    if (FOG && !is_background) {
        exposed_light = fogged(exposed_light, gbuffer_read().position_world);
    }
    target_output = whole_color(exposed_light, is_background);
}
