#version 450
// What a surface reflects of one light, added to the light target by fixed-function blending.
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "frame.glsl"
#include "pixel.glsl"
#include "gbuffer/surface.glsl"
#include "brdf.glsl"
#include "fragment.glsl"
#include "light/direct.glsl"
#include "fog.glsl"

// Mirrors LightPush in src/gpu/shared.rs.
layout(push_constant, std430) uniform LightPush {
    uint light; // number among the frame's lights
} push;

layout(location = TARGET_LIGHT) out vec4 target_light;

void main() {
    Surface surface = surface_at_fragment().surface;
    vec3 position = surface.position_world;
    vec3 light = vec3(0.0);
    if (push.light < frame.light_counts.x || is_lit_from(push.light, surface, position)) {
        Reflector r = reflector(surface, view_direction_world());
        light = complete(light_reflected(push.light, surface, r, position), surface);
        if (FOG) {
            // The fog's own light is in the base.
            light *= fog_transmittance(ray_origin_world(), position);
        }
    }
    target_light = vec4(light * (frame.exposure * frame.light_scale), 0.0);
}
