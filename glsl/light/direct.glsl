// What light sources add to a surface: shared by every pass that lights surfaces, deferred and forward.

#include "light/punctual.glsl"
#include "light/extent.glsl"
#include "light/globe.glsl"
#include "light/clusters.glsl"
#include "light/shadow.glsl"

layout(constant_id = ID_HAS_DIRECTIONAL) const bool HAS_DIRECTIONAL = false;
layout(constant_id = ID_HAS_POINT) const bool HAS_POINT = false;
layout(constant_id = ID_HAS_SPOT) const bool HAS_SPOT = false;
layout(constant_id = ID_HAS_BOX) const bool HAS_BOX = false;
layout(constant_id = ID_HAS_HEMISPHERE) const bool HAS_HEMISPHERE = false;
layout(constant_id = ID_HAS_BACK) const bool HAS_BACK = false;
layout(constant_id = ID_CLUSTERS) const bool CLUSTERS = false; // lights with a place are listed by cell
layout(constant_id = ID_GLOBE_MAPS) const bool GLOBE_MAPS = false;
layout(constant_id = ID_SHADOWS) const bool SHADOWS = false;
// Lights whose shadows are volumes (Light.shadow says so) are added by themselves.
layout(constant_id = ID_SHADOW_VOLUMES) const bool SHADOW_VOLUMES = false;
const uint SHADOW_BY_VOLUME = 0xffffffffu;
// Lights that have a place, and lights that all pixels go through.
#define HAS_PLACED (HAS_POINT || HAS_SPOT || HAS_BOX)
#define HAS_SCANNED (HAS_DIRECTIONAL || (HAS_PLACED && !CLUSTERS))

// What a surface at `position` reflects of one light, world space. The light's kind follows from its place in the list; where
// there is but one kind nothing is asked.
Reflected light_reflected(uint i, Surface surface, Reflector r, vec3 position) {
    if (SHADOW_VOLUMES && lights[i].shadow == SHADOW_BY_VOLUME) {
        return Reflected(vec3(0.0), vec3(0.0));
    }
    uint point_begin = frame.light_counts.x;
    uint spot_begin = point_begin + frame.light_counts.y;
    uint box_begin = spot_begin + frame.light_counts.z;
    Incident incident;
    if (HAS_DIRECTIONAL && (!HAS_PLACED || i < point_begin)) {
        incident = light_directional(lights[i]);
    } else if (HAS_BOX && (!(HAS_POINT || HAS_SPOT) || i >= box_begin)) {
        incident = light_box(lights[i], position);
    } else if (HAS_SPOT && (!HAS_POINT || i >= spot_begin)) {
        incident = light_spot(lights[i], position);
    } else {
        incident = light_point(lights[i], position);
    }
    if (GLOBE_MAPS && lights[i].globe_map != 0u) {
        vec3 position_light = in_light_frame(lights[i], position);
        if (!HAS_POINT || i >= spot_begin) {
            bool is_spot = HAS_SPOT && (!HAS_BOX || i < box_begin);
            incident.illuminance *= globe_flat(lights[i], position_light, is_spot);
        } else {
            incident.illuminance *= globe_cube(lights[i], position_light);
        }
    }
    float n_dot_l = dot(surface.normal_world, incident.direction);
    if (SHADOWS && lights[i].shadow != 0u && n_dot_l > 0.0 && incident.illuminance != vec3(0.0)) {
        incident.illuminance *= shadow(
            lights[i].shadow, lights[i].place.xyz, position, surface.normal_world, incident.direction);
    }
    Reflected light = brdf(r, incident.direction, clamp(n_dot_l, 0.0, 1.0));
    vec3 irradiance = incident.illuminance * max(n_dot_l, 0.0);
    light.diffuse *= irradiance;
    light.specular *= irradiance;
    if (HAS_BACK) {
        light.diffuse += incident.back * max(-n_dot_l, 0.0);
    }
    return light;
}

// Whether a light with a place can add anything but 0: the surface is in its reach and does not face away from it.
bool is_lit_from(uint i, Surface surface, vec3 position) {
    if (HAS_BOX && i >= frame.light_counts.x + frame.light_counts.y + frame.light_counts.z) {
        bool faces = HAS_BACK || dot(surface.normal_world, lights[i].direction_world) < 0.0;
        return faces && all(lessThan(abs(in_light_frame(lights[i], position)), lights[i].half_size));
    }
    vec4 place = lights[i].place;
    vec3 to_light = place.xyz - position;
    bool in_range = dot(to_light, to_light) * (place.w * place.w) < 1.0;
    return in_range && dot(surface.normal_world, to_light) > 0.0;
}

void add(inout Reflected sum, Reflected light) {
    sum.diffuse += light.diffuse;
    sum.specular += light.specular;
}

// Adds what a surface at `position` reflects of the lights listed for its cell.
void add_listed_light(inout Reflected sum, Surface surface, Reflector r, vec3 position) {
    uvec2 list = cluster_list(position);
    for (uint next = list.x; next < list.y; ++next) {
        uint i = clusters.words[next];
        // Neighbours nearly always agree, so that looking for one's own next light would save nothing.
        if (is_lit_from(i, surface, position)) {
            add(sum, light_reflected(i, surface, r, position));
        }
    }
}

// What a surface reflects of the lights that the list does not have, since they come from everywhere at once.
Reflected unlisted_light(Surface surface) {
    return Reflected(HAS_HEMISPHERE ? light_hemispheres(surface.normal_world) : vec3(0.0), vec3(0.0));
}

// What a surface reflects of all lights towards `v`, in world space.
Reflected direct_light(Surface surface, vec3 v) {
    Reflector r = reflector(surface, v);
    vec3 position = surface.position_world;
    Reflected sum = unlisted_light(surface);
    if (HAS_SCANNED) {
        uvec4 counts = frame.light_counts * uvec4(HAS_DIRECTIONAL, HAS_POINT, HAS_SPOT, HAS_BOX);
        uint everywhere = CLUSTERS ? counts.x : counts.x + counts.y + counts.z + counts.w;
        for (uint i = 0u; i < everywhere; ++i) {
            add(sum, light_reflected(i, surface, r, position));
        }
    }
    if (CLUSTERS) {
        add_listed_light(sum, surface, r, position);
    }
    return sum;
}
