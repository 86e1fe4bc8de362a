// What light sources add to a surface: shared by every pass that lights surfaces, deferred and forward.

#include "light/punctual.glsl"
#ifdef SHADOWS
#include "light/shadow.glsl"
#endif

layout(constant_id = ID_HAS_DIRECTIONAL) const bool HAS_DIRECTIONAL = false;
layout(constant_id = ID_HAS_POINT) const bool HAS_POINT = false;
layout(constant_id = ID_HAS_SPOT) const bool HAS_SPOT = false;

// What the surface at `position` reflects of one light towards `v`.
vec3 reflected(Surface surface, vec3 position, vec3 v, Light light, Incident incident) {
    float n_dot_l = max(dot(surface.normal_world, incident.direction), 0.0);
#ifdef SHADOWS
    if (light.shadow != 0u && n_dot_l > 0.0 && incident.illuminance != vec3(0.0)) {
        incident.illuminance *=
            shadow(light.shadow, light.position_world, position, surface.normal_world, incident.direction);
    }
#endif
    return brdf(surface, surface.normal_world, v, incident.direction) * (incident.illuminance * n_dot_l);
}

// The first light from `i` to `end` in whose range and in front of whose position the surface is; others add exactly 0.
// Each pixel of a group looks for its own next light, so that the group evaluates the BRDF as often as the pixel with
// the most lights needs it. A branch around the BRDF would save less, and nothing where pixels are only masked (lavapipe).
uint next_light(uint i, uint end, Surface surface, vec3 position) {
    while (i < end) {
        vec3 to_light = lights[i].position_world - position;
        float inverse_range = lights[i].inverse_range;
        bool in_range = dot(to_light, to_light) * (inverse_range * inverse_range) < 1.0;
        if (in_range && dot(surface.normal_world, to_light) > 0.0) {
            break;
        }
        ++i;
    }
    return i;
}

// What a surface at `position` reflects of all lights towards `v`, both world space: cd/m^2.
vec3 direct_light(Surface surface, vec3 position, vec3 v) {
    uint point_begin = frame.light_counts.x;
    uint spot_begin = point_begin + frame.light_counts.y;
    uint spot_end = spot_begin + frame.light_counts.z;

    vec3 sum = vec3(0.0);
    if (HAS_DIRECTIONAL) {
        for (uint i = 0u; i < point_begin; ++i) {
            sum += reflected(surface, position, v, lights[i], light_directional(lights[i]));
        }
    }
    if (HAS_POINT) {
        for (uint i = point_begin; (i = next_light(i, spot_begin, surface, position)) < spot_begin; ++i) {
            sum += reflected(surface, position, v, lights[i], light_point(lights[i], position));
        }
    }
    if (HAS_SPOT) {
        for (uint i = spot_begin; (i = next_light(i, spot_end, surface, position)) < spot_end; ++i) {
            sum += reflected(surface, position, v, lights[i], light_spot(lights[i], position));
        }
    }
    return sum;
}
