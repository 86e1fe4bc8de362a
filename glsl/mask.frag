#version 450
// The holes that an alpha mask cuts into a surface of which only depth is drawn; solid ones have no fragment shader.
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "material.glsl"

void main() {
    if (material_is_cut(material_base_color().a)) {
        discard;
    }
}
