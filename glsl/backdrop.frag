#version 450
// Copies light and depth of what is opaque to where media are drawn, which sample them.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#include "common.glsl"

layout(constant_id = ID_HAS_BEHIND) const bool HAS_BEHIND = false; // else there is no depth

layout(set = SET_INPUTS, binding = BINDING_BEHIND_LIGHT) uniform texture2D behind_light;
layout(set = SET_INPUTS, binding = BINDING_BEHIND_DEPTH) uniform texture2D behind_depth;

layout(location = TARGET_LIGHT) out vec4 target_light;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    target_light = texelFetch(behind_light, pixel, 0);
    gl_FragDepth = HAS_BEHIND ? texelFetch(behind_depth, pixel, 0).r : 0.0;
}
