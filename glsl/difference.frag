#version 450
// How far the picture, which is on the tile, is from another one, of which this pixel is sampled: the absolute difference of what
// displays are told, amplified. src/plan/difference.rs says the same.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#include "common.glsl"
#include "srgb.glsl"

layout(constant_id = ID_DIFFERENCE_GAIN) const float DIFFERENCE_GAIN = 1.0;
layout(constant_id = ID_FLOAT_OUTPUT) const bool FLOAT_OUTPUT = false;

layout(INPUT_AT(INPUT_PICTURE)) uniform inputAttachment input_picture;
layout(set = SET_INPUTS, binding = BINDING_OTHER) uniform texture2D other;

layout(location = TARGET_OUTPUT) out vec4 target_output;

void main() {
    vec3 own = input_load(input_picture).rgb;
    vec3 others = texelFetch(other, ivec2(gl_FragCoord.xy), 0).rgb;
    if (FLOAT_OUTPUT) {
        target_output = vec4(abs(own - others) * DIFFERENCE_GAIN, 1.0);
        return;
    }
    vec3 apart = abs(srgb_from_linear(own) - srgb_from_linear(others));
    target_output = vec4(linear_from_srgb(clamp(apart * DIFFERENCE_GAIN, 0.0, 1.0)), 1.0);
}
