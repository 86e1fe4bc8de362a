#version 450
// Triangles in pixels, or in points of a screen that has several pixels each.
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"

layout(push_constant, std430) uniform Push {
    mat2 clip_from_point; // 2 / the picture's size in points, turned as the image is
    vec2 origin_clip;     // the left upper corner of the picture
} push;

layout(location = ATTRIBUTE_POSITION) in vec2 attribute_position; // from the left upper corner
layout(location = ATTRIBUTE_TEXCOORD) in vec2 attribute_texcoord;
layout(location = ATTRIBUTE_COLOR) in vec4 attribute_color;

layout(location = VARYING_TEXCOORD) out vec2 varying_texcoord;
layout(location = VARYING_COLOR) out vec4 varying_color;

void main() {
    varying_texcoord = attribute_texcoord;
    varying_color = attribute_color;
    gl_Position = vec4(push.clip_from_point * attribute_position + push.origin_clip, 0.0, 1.0);
}
