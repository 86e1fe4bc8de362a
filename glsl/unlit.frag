#version 450
// Geometry of a scene in which nothing is lit: straight to the output.
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "frame.glsl"
#include "pixel.glsl"
#include "fog.glsl"
#include "material.glsl"
#include "tonemap.glsl"

layout(location = TARGET_OUTPUT) out vec4 target_output;

void main() {
    vec4 base_color = material_base_color();
    if (material_is_cut(base_color.a)) {
        discard;
    }
    vec3 exposed_light = base_color.rgb * frame.exposure;
    if (FOG) {
        exposed_light = fogged(exposed_light, position_world(gl_FragCoord.z));
    }
    target_output = output_color(exposed_light);
}
