// Lights without extent: KHR_lights_punctual.

// Mirrors LightData in src/gpu/shared.rs.
struct Light {
    vec4 place;           // position, world; w: 1 / range in 1 / m, 0: infinite. One load where lights are looked through
    vec3 intensity;       // colour * candela, directional and box: colour * lux
    float edge;           // of a spot: spot_falloff's scale; of a box the width of its falloff, metres
    vec3 direction_world; // the way the light travels
    float spot_offset;
    vec3 up_world;        // the light's +Y
    float globe_rotation; // radians
    vec3 back_intensity;  // lux on surfaces that face away
    uint shadow;          // shadow.glsl; 0: none
    vec3 half_size;       // of a box, metres; of a spot's globe map at a distance of 1 m
    uint globe_map;       // its first layer + 1; 0: none
};

// Directional lights first, then point, spot, box: frame.light_counts.
layout(set = SET_FRAME, binding = BINDING_LIGHTS, std430) readonly buffer Lights {
    Light lights[];
};

// What reaches a point from one light.
struct Incident {
    vec3 direction;    // towards the light, unit length
    vec3 illuminance;  // lux, on a surface that faces the light
    vec3 back;         // lux, on a surface that faces away, as diffuse light
};

// At a light's centre the inverse square has no limit: it is held at the value of 0.1 mm.
const float MIN_DISTANCE_SQUARED = 1e-8;

// "Range property": max(min(1 - (distance / range)^4, 1), 0).
float range_window(float distance, float inverse_range) {
    float x = distance * inverse_range;
    float x2 = x * x;
    return clamp(1.0 - x2 * x2, 0.0, 1.0);
}

// "Inner and outer cone angles": 1 within the inner cone, 0 outside the outer one.
// scale = 1 / max(0.001, cos(inner) - cos(outer)), offset = -cos(outer) * scale.
float spot_falloff(float direction_cosine, float scale, float offset) {
    float attenuation = clamp(direction_cosine * scale + offset, 0.0, 1.0);
    return attenuation * attenuation;
}

Incident light_directional(Light light) {
    return Incident(-light.direction_world, light.intensity, light.back_intensity);
}

Incident light_point(Light light, vec3 position_world) {
    vec3 to_light = light.place.xyz - position_world;
    float distance_squared = max(dot(to_light, to_light), MIN_DISTANCE_SQUARED);
    float inverse_distance = inversesqrt(distance_squared);
    float window = range_window(distance_squared * inverse_distance, light.place.w);
    return Incident(to_light * inverse_distance, light.intensity * (window / distance_squared), vec3(0.0));
}

Incident light_spot(Light light, vec3 position_world) {
    Incident incident = light_point(light, position_world);
    float direction_cosine = dot(light.direction_world, -incident.direction);
    incident.illuminance *= spot_falloff(direction_cosine, light.edge, light.spot_offset);
    return incident;
}
