// Radiance by direction, prefiltered by src/environment; the sky, and what surfaces receive of it.

layout(constant_id = ID_RGBM) const bool RGBM = false;

// Mirrors EnvironmentUniforms in src/gpu/shared.rs.
layout(set = SET_FRAME, binding = BINDING_ENVIRONMENT, std140) uniform Environment {
    vec4 irradiance[9];  // over pi, cd/m^2, of the harmonics below
    vec2 rotation;       // cosine and sine of the angle about +Y
    float scale;         // cd/m^2 of a stored 1
    float last_level;    // the level for roughness 1
} environment;

// Vulkan's faces in each environment's own space; level for roughness r: last_level r (2 - r).
layout(set = SET_FRAME, binding = BINDING_RADIANCE) uniform samplerCube radiance;

// There are probes, and in the same place an array: the environment if there is one, then the probes in order.
layout(constant_id = ID_PROBES) const bool PROBES = false;
layout(constant_id = ID_HAS_ENVIRONMENT) const bool HAS_ENVIRONMENT = false;
layout(set = SET_FRAME, binding = BINDING_RADIANCES) uniform samplerCubeArray radiances;

// Turned about +Y into the space of a picture.
vec3 turned(vec3 d, vec2 rotation) {
    return vec3(rotation.x * d.x - rotation.y * d.z, d.y, rotation.y * d.x + rotation.x * d.z);
}

// Smith and Einig 2015, listing 2.5.
vec3 decode_radiance(vec4 stored) {
    const float rgbm_range = 6.0;
    vec3 root = stored.rgb * (stored.a * rgbm_range);
    return RGBM ? root * root : stored.rgb;
}

// Where the lobe of a rough surface takes most of its light from: between the mirror direction and the normal. Not of unit
// length. (Lagarde and de Rousiers, "Moving Frostbite to Physically Based Rendering", 2014, section 4.9.3, listing 21.)
vec3 dominant_direction(vec3 n, vec3 v, float roughness) {
    float alpha = roughness * roughness;
    float smoothness = 1.0 - alpha;
    return mix(n, reflect(-v, n), smoothness * (sqrt(smoothness) + alpha));
}

// Irradiance over pi, cd/m^2: real spherical harmonics of the orders 0 to 2 (Ramamoorthi and Hanrahan 2001), which ring
// below zero opposite a small bright light.
vec3 environment_irradiance_nt(vec3 normal_world) {
    vec3 d = turned(normal_world, environment.rotation);
    vec3 sum = environment.irradiance[0].rgb + environment.irradiance[1].rgb * d.y + environment.irradiance[2].rgb * d.z
        + environment.irradiance[3].rgb * d.x + environment.irradiance[4].rgb * (d.x * d.y)
        + environment.irradiance[5].rgb * (d.y * d.z) + environment.irradiance[6].rgb * (3.0 * d.z * d.z - 1.0)
        + environment.irradiance[7].rgb * (d.x * d.z) + environment.irradiance[8].rgb * (d.x * d.x - d.y * d.y);
    return max(sum, 0.0);
}

float radiance_level(float roughness) {
    return environment.last_level * roughness * (2.0 - roughness);
}

// Radiance in cd/m^2 around a direction in the world, which need not be of unit length.
vec3 environment_radiance_nt(vec3 direction_world, float roughness) {
    vec3 towards = turned(direction_world, environment.rotation);
    float level = radiance_level(roughness);
    vec4 stored = PROBES ? textureLod(radiances, vec4(towards, 0.0), level) : textureLod(radiance, towards, level);
    return decode_radiance(stored) * environment.scale;
}
