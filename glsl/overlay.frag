#version 450
// Colours are encoded as sRGB, multiplied by alpha after that, and are mixed with the picture as light: the attachment encodes it.
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "srgb.glsl"

layout(constant_id = ID_BLOOM_STORED) const bool BLOOM_STORED = false; // light is beside the picture

layout(set = SET_POST, binding = BINDING_POST_COLOR) uniform sampler2D post_color;

layout(location = VARYING_TEXCOORD) in vec2 varying_texcoord;
layout(location = VARYING_COLOR) in vec4 varying_color;

layout(location = TARGET_OUTPUT) out vec4 target_output;
layout(location = TARGET_BLOOM_LIGHT) out vec4 target_bloom_light;

void main() {
    vec4 encoded = varying_color * texture(post_color, varying_texcoord);
    target_output = vec4(linear_from_srgb(encoded.rgb), encoded.a);
    if (BLOOM_STORED) {
        // Blended as the picture is: nothing over it.
        target_bloom_light = vec4(0.0);
    }
}
