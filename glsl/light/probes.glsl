// What glossy surfaces reflect inside boxes. Wants light/environment.glsl.

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
    float level = radiance_level(roughness);
    float first = HAS_ENVIRONMENT ? 1.0 : 0.0;
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
            vec4 stored = textureLod(radiances, vec4(towards, first + float(i)), level);
            sum += decode_radiance(stored) * (probe.scale * weight);
            weights += weight;
        }
    }
    sum /= max(weights, 1.0);
    if (weights < 1.0) {
        vec3 far_nt = ambient_nt;
        if (HAS_ENVIRONMENT) {
            far_nt += environment_radiance_nt(direction_world, roughness);
        }
        sum += far_nt * (1.0 - weights);
    }
    return sum;
}
