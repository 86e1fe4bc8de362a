#version 450
// Writes a material's surface to the G-buffer, and the light that needs no other pixel (emissive, ambient, unlit)
// to the light target where the plan has one (LIGHT_TARGET).
#extension GL_GOOGLE_include_directive : require
#define SUBPASS_GEOMETRY
#include "common.glsl"
#include "frame.glsl"
#include "pixel.glsl"
#include "gbuffer.glsl"
#include "brdf.glsl"
#include "fragment.glsl"

layout(constant_id = ID_LIGHT_TARGET) const bool LIGHT_TARGET = false;

layout(location = TARGET_LIGHT) out vec4 target_light;

void main() {
    Fragment fragment = surface_at_fragment();
    gbuffer_write(fragment.surface);
    if (LIGHT_TARGET) {
        target_light = vec4(indirect_light(fragment) * (frame.exposure * frame.light_scale), 1.0);
    }
}
