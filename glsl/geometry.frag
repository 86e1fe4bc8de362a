#version 450
// Writes a material's surface to the G-buffer, and the light that needs no other pixel (emissive, ambient, unlit) to the light
// target (LIGHT_TARGET) or into the G-buffer (LIGHT_READ), where the plan has a place for it.
#extension GL_GOOGLE_include_directive : require
#define SUBPASS_GEOMETRY
#include "common.glsl"
#include "frame.glsl"
#include "pixel.glsl"
#include "gbuffer.glsl"
#include "brdf.glsl"
#include "fragment.glsl"

void main() {
    Fragment fragment = surface_at_fragment();
    vec4 light = vec4(0.0, 0.0, 0.0, 1.0);
    if (LIGHT_TARGET || LIGHT_READ) {
        light.rgb = indirect_light(fragment) * (frame.exposure * frame.light_scale);
    }
    write_edge(ALPHA_MASK);
    write_occlusion(fragment.occlusion);
    gbuffer_write(fragment.surface, fragment.base_color, fragment.metallic, light);
    if (LIGHT_TARGET) {
        light_write(light);
    }
}
