// Radiance by direction, prefiltered by src/environment: far away, and with PROBES another inside boxes.

layout(constant_id = ID_RGBM) const bool RGBM = false;

// Mirrors EnvironmentUniforms in src/gpu/shared.rs.
layout(set = SET_FRAME, binding = BINDING_ENVIRONMENT, std140) uniform Environment {
    vec4 irradiance[9];  // over pi, cd/m^2, of the harmonics below
    vec2 rotation;       // cosine and sine of the angle about +Y
    float scale;         // cd/m^2 of a stored 1
    float last_level;    // the level for roughness 1
} environment;

// Vulkan's faces in each environment's own space; level for roughness r: last_level r (2 - r).
#ifdef PROBES
layout(constant_id = ID_HAS_ENVIRONMENT) const bool HAS_ENVIRONMENT = false;

// The probes' in order, then the environment's.
layout(set = SET_FRAME, binding = BINDING_RADIANCE) uniform samplerCubeArray radiance;

// Mirrors ProbeData in src/gpu/shared.rs.
struct Probe {
    vec4 probe_from_world_rows[3];
    vec3 half_size;  // metres
    float falloff;   // metres
    vec2 rotation;   // as of the environment
    float scale;     // likewise
    float padding;
};

layout(set = SET_FRAME, binding = BINDING_PROBES, std430) readonly buffer Probes {
    Probe probes[];
};
#else
layout(set = SET_FRAME, binding = BINDING_RADIANCE) uniform samplerCube radiance;
#endif

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

#ifdef PROBES

// 0 outside the box, smoothstep over the falloff inside each face, the three axes multiplied.
float probe_weight(Probe probe, vec3 position) {
    const float min_falloff = 1e-4;
    vec3 widths = min(vec3(max(probe.falloff, min_falloff)), probe.half_size);
    vec3 t = clamp((probe.half_size - abs(position)) / widths, 0.0, 1.0);
    vec3 s = t * t * (3.0 - 2.0 * t);
    return s.x * s.y * s.z;
}

// From the box's centre to where a ray leaves the box (Lagarde and Zanuttini, "Local Image-based Lighting With
// Parallax-corrected Cubemap", 2012). A face that the ray runs along is far away.
vec3 box_projected(Probe probe, vec3 position, vec3 direction) {
    vec3 ahead = mix(probe.half_size, -probe.half_size, lessThan(direction, vec3(0.0)));
    vec3 distances = abs(ahead - position) / max(abs(direction), 1e-12);
    return position + direction * min(distances.x, min(distances.y, distances.z));
}

// Radiance in cd/m^2 around a direction, which need not be of unit length, seen from a place: that of the probes around it by
// weight, and that of what is far away, `ambient_nt` included, for what is left.
vec3 specular_radiance_nt(vec3 position_world, vec3 direction_world, float roughness, vec3 ambient_nt) {
    float level = environment.last_level * roughness * (2.0 - roughness);
    vec4 place = vec4(position_world, 1.0);
    vec3 sum = vec3(0.0);
    float weights = 0.0;
    for (int i = 0; i < probes.length(); ++i) {
        Probe probe = probes[i];
        vec4 rows[3] = probe.probe_from_world_rows;
        vec3 position = vec3(dot(rows[0], place), dot(rows[1], place), dot(rows[2], place));
        float weight = probe_weight(probe, position);
        if (weight > 0.0) {
            vec3 direction = vec3(
                dot(rows[0].xyz, direction_world), dot(rows[1].xyz, direction_world), dot(rows[2].xyz, direction_world));
            vec3 towards = turned(box_projected(probe, position, direction), probe.rotation);
            vec4 stored = textureLod(radiance, vec4(towards, float(i)), level);
            sum += decode_radiance(stored) * (probe.scale * weight);
            weights += weight;
        }
    }
    sum /= max(weights, 1.0);
    if (weights < 1.0) {
        vec3 far_nt = ambient_nt;
        if (HAS_ENVIRONMENT) {
            vec4 towards = vec4(turned(direction_world, environment.rotation), float(probes.length()));
            far_nt += decode_radiance(textureLod(radiance, towards, level)) * environment.scale;
        }
        sum += far_nt * (1.0 - weights);
    }
    return sum;
}

#else

// Radiance in cd/m^2 around a direction, which need not be of unit length.
vec3 specular_radiance_nt(vec3 direction_world, float roughness, vec3 ambient_nt) {
    float level = environment.last_level * roughness * (2.0 - roughness);
    vec4 stored = textureLod(radiance, turned(direction_world, environment.rotation), level);
    return ambient_nt + decode_radiance(stored) * environment.scale;
}

#endif
