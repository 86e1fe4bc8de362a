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
    float n_dot_l = max(dot(surface.normal_world, incident.direction), 0.0);
    return brdf(surface, surface.normal_world, v, incident.direction) * (incident.illuminance * n_dot_l);
}

// The first light from `i` to `end` in whose range and in front of whose position the surface is; others add exactly 0.
// Each pixel of a group looks for its own next light, so that the group evaluates the BRDF as often as the pixel with
// the most lights needs it. A branch around the BRDF would save less, and nothing where pixels are only masked (lavapipe).
uint next_light(uint i, uint end, Surface surface, vec3 position_world) {
    while (i < end) {
        vec3 to_light = lights[i].position_world - position_world;
        float inverse_range = lights[i].inverse_range;
        bool in_range = dot(to_light, to_light) * (inverse_range * inverse_range) < 1.0;
        if (in_range && dot(surface.normal_world, to_light) > 0.0) {
            break;
        }
        ++i;
    }
    return i;
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
        for (uint i = point_begin; (i = next_light(i, spot_begin, surface, position)) < spot_begin; ++i) {
            sum += reflected(surface, v, light_point(lights[i], position));
        }
    }
    if (HAS_SPOT) {
        for (uint i = spot_begin; (i = next_light(i, spot_end, surface, position)) < spot_end; ++i) {
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
