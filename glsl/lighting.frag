#version 450
// All punctual lights on one pixel. FOLD: tonemaps and writes the output; else fixed-function blending adds to the
// light target.
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "frame.glsl"
#include "pixel.glsl"
#include "gbuffer.glsl"
#include "brdf.glsl"
#include "light/punctual.glsl"
#include "tonemap.glsl"

layout(constant_id = ID_HAS_DIRECTIONAL) const bool HAS_DIRECTIONAL = false;
layout(constant_id = ID_HAS_POINT) const bool HAS_POINT = false;
layout(constant_id = ID_HAS_SPOT) const bool HAS_SPOT = false;
layout(constant_id = ID_FOLD) const bool FOLD = false;

layout(location = TARGET_OUTPUT) out vec4 target_output;

vec3 reflected(Surface surface, vec3 v, Incident incident) {
    vec3 irradiance = incident.illuminance * max(dot(surface.normal_world, incident.direction), 0.0);
    // Behind the surface, out of range or beside the cone, as most lights are for most pixels.
    if (irradiance == vec3(0.0)) {
        return vec3(0.0);
    }
    return brdf(surface, surface.normal_world, v, incident.direction) * irradiance;
}

// cd/m^2 towards the viewer.
vec3 punctual_lights(Surface surface) {
    vec3 v = view_direction_world();
    vec3 position = position_world(surface.depth);
    uint point_begin = frame.light_counts.x;
    uint spot_begin = point_begin + frame.light_counts.y;
    uint spot_end = spot_begin + frame.light_counts.z;

    vec3 sum = vec3(0.0);
    if (HAS_DIRECTIONAL) {
        for (uint i = 0u; i < point_begin; ++i) {
            sum += reflected(surface, v, light_directional(lights[i]));
        }
    }
    if (HAS_POINT) {
        for (uint i = point_begin; i < spot_begin; ++i) {
            sum += reflected(surface, v, light_point(lights[i], position));
        }
    }
    if (HAS_SPOT) {
        for (uint i = spot_begin; i < spot_end; ++i) {
            sum += reflected(surface, v, light_spot(lights[i], position));
        }
    }
    return sum;
}

void main() {
    Surface surface = gbuffer_read();
    vec3 exposed_light = vec3(0.0);
    if (surface.lit) {
        exposed_light = punctual_lights(surface) * frame.exposure;
    }
    // Pixels that are not lit add 0. `discard` would save tilers nothing, since blending stays on the tile, but it
    // makes a fragment's coverage depend on its shader, which costs Mali its early kills and PowerVR its deferral.
    // Folded, there is no one else to write the background: tonemapped 0, as tonemap.frag would.
    target_output = FOLD ? output_color(exposed_light) : vec4(exposed_light * frame.light_scale, 0.0);
}
