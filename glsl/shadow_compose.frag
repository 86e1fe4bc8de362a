#version 450
// A tile of the shadow map begins as the static map, which is bound here, has it; what moves is drawn over that.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#include "common.glsl"

layout(set = SET_FRAME, binding = BINDING_SHADOW_MAP) uniform texture2D shadow_map;

void main() {
    gl_FragDepth = texelFetch(shadow_map, ivec2(gl_FragCoord.xy), 0).r;
}
