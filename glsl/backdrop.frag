#version 450
// Copies light and depth of what is opaque to where media are drawn, which sample them.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#include "common.glsl"

layout(constant_id = ID_HAS_BEHIND) const bool HAS_BEHIND = false; // else there is no depth

#define SET_BEHIND SET_INPUTS
#include "backdrop.glsl"

layout(location = TARGET_LIGHT) out vec4 target_light;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    target_light = fetch_behind(behind_light, pixel);
    gl_FragDepth = HAS_BEHIND ? fetch_behind(behind_depth, pixel).r : 0.0;
}
