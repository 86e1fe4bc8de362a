// Encodings of a direction, each with the roughness beside it in one target. All 0 is no surface's: it says "not lit".

layout(constant_id = ID_NORMALS) const uint NORMALS = NORMALS_XYZ;

// The view's axes in world space: right, up, towards the viewer.
mat3 world_from_view() {
    return mat3(normalize(frame.right_world.xyz), -normalize(frame.down_world.xyz), -frame.forward_world.xyz);
}

// The octahedron's unfolding, [-1, 1]^2 (Meyer et al., "On Floating-Point Normal Vectors", 2010; Cigolle et al. 2014).
vec2 octahedral_from_direction(vec3 n) {
    vec2 p = n.xy / (abs(n.x) + abs(n.y) + abs(n.z));
    vec2 folded = (1.0 - abs(p.yx)) * mix(vec2(-1.0), vec2(1.0), greaterThanEqual(p, vec2(0.0)));
    return n.z < 0.0 ? folded : p;
}

vec3 direction_from_octahedral(vec2 p) {
    vec3 n = vec3(p, 1.0 - abs(p.x) - abs(p.y));
    float t = max(-n.z, 0.0);
    n.xy -= mix(vec2(-t), vec2(t), greaterThanEqual(n.xy, vec2(0.0)));
    return unit(n);
}

// Codes 0 to 2 h for -1 to 1: an even number of steps, so that 0, and with it the axes, is kept exactly.
uvec2 codes_of(vec2 p, float h) {
    return uvec2(clamp(p * h + (h + 0.5), 0.0, 2.0 * h + 0.5));
}

vec2 from_codes(uvec2 codes, float h) {
    return vec2(codes) / h - 1.0;
}

// All four corners of the unfolding are the direction -z; code (0, 0) is left to "not lit".
uvec2 octahedral_codes(vec3 n, float h) {
    uvec2 codes = codes_of(octahedral_from_direction(n), h);
    return codes == uvec2(0u) ? uvec2(2.0 * h) : codes;
}

// Lambert's azimuthal equal-area map of view space, singular at directions straight away from the viewer (Pranckevicius,
// "Compact Normal Storage for Small G-Buffers", 2010, method 4).
vec2 spheremap_from_direction(vec3 n) {
    return n.xy * inversesqrt(max(2.0 * n.z + 2.0, 1e-12));
}

vec3 direction_from_spheremap(vec2 p) {
    float f = dot(p, p);
    return vec3(p * (2.0 * sqrt(max(1.0 - f, 0.0))), 1.0 - 2.0 * f);
}

// Two codes of 12 bits and 8 bits more in four bytes.
vec4 bytes_of(uvec2 codes, float roughness) {
    uvec3 bytes = uvec3(codes.x >> 4, (codes.x & 15u) << 4 | codes.y >> 8, codes.y & 255u);
    return vec4(vec3(bytes) / 255.0, roughness);
}

uvec2 codes_in(vec4 stored) {
    uvec3 bytes = uvec3(stored.xyz * 255.0 + 0.5);
    return uvec2(bytes.x << 4 | bytes.y >> 4, (bytes.y & 15u) << 8 | bytes.z);
}

const float HALF_STEPS_12 = 2047.0; // of 4095 codes
const float HALF_STEPS_10 = 511.0;
const float HALF_STEPS_8 = 127.0;
const float HALF_STEPS_16 = 32767.0;

vec4 encode_normal_roughness(vec3 normal_world, float roughness) {
    if (NORMALS == NORMALS_FLOAT) {
        return vec4(normal_world, roughness);
    } else if (NORMALS == NORMALS_XYZ) {
        return vec4(normal_world * 0.5 + 0.5, roughness);
    } else if (NORMALS == NORMALS_OCTAHEDRAL_8) {
        return vec4(vec2(octahedral_codes(normal_world, HALF_STEPS_8)) / 255.0, roughness, 1.0);
    } else if (NORMALS == NORMALS_OCTAHEDRAL_10) {
        return vec4(vec2(octahedral_codes(normal_world, HALF_STEPS_10)) / 1023.0, roughness, 1.0);
    } else if (NORMALS == NORMALS_OCTAHEDRAL_16) {
        return vec4(vec2(octahedral_codes(normal_world, HALF_STEPS_16)) / 65535.0, roughness, 1.0);
    } else if (NORMALS == NORMALS_OCTAHEDRAL_12) {
        return bytes_of(octahedral_codes(normal_world, HALF_STEPS_12), roughness);
    } else if (NORMALS == NORMALS_SPHEREMAP_12) {
        vec3 normal_view = normal_world * world_from_view();
        return bytes_of(codes_of(spheremap_from_direction(normal_view), HALF_STEPS_12), roughness);
    }
    vec3 normal_view = normal_world * world_from_view();
    return bytes_of(codes_of(normal_view.xy, HALF_STEPS_12), roughness);
}

bool is_lit(vec4 stored) {
    return stored.xyz != vec3(0.0);
}

vec3 decode_normal(vec4 stored) {
    if (NORMALS == NORMALS_FLOAT) {
        return stored.xyz;
    } else if (NORMALS == NORMALS_XYZ) {
        // 8 bits do not keep the length.
        return unit(stored.xyz * 2.0 - 1.0);
    } else if (NORMALS == NORMALS_OCTAHEDRAL_8) {
        return direction_from_octahedral(stored.xy * (255.0 / HALF_STEPS_8) - 1.0);
    } else if (NORMALS == NORMALS_OCTAHEDRAL_10) {
        return direction_from_octahedral(stored.xy * (1023.0 / HALF_STEPS_10) - 1.0);
    } else if (NORMALS == NORMALS_OCTAHEDRAL_16) {
        return direction_from_octahedral(stored.xy * (65535.0 / HALF_STEPS_16) - 1.0);
    }
    vec2 p = from_codes(codes_in(stored), HALF_STEPS_12);
    if (NORMALS == NORMALS_OCTAHEDRAL_12) {
        return direction_from_octahedral(p);
    } else if (NORMALS == NORMALS_SPHEREMAP_12) {
        return unit(world_from_view() * direction_from_spheremap(p));
    }
    // Surfaces face the viewer, so z is taken to be positive (Koonce 2007, 19.6.1).
    return unit(world_from_view() * vec3(p, sqrt(max(1.0 - dot(p, p), 0.0))));
}

bool has_roughness_third() {
    return NORMALS == NORMALS_OCTAHEDRAL_8 || NORMALS == NORMALS_OCTAHEDRAL_10 || NORMALS == NORMALS_OCTAHEDRAL_16;
}

float decode_roughness(vec4 stored) {
    return has_roughness_third() ? stored.z : stored.w;
}

// The same normal beside another roughness.
vec4 with_roughness(vec4 stored, float roughness) {
    return has_roughness_third() ? vec4(stored.xy, roughness, stored.w) : vec4(stored.xyz, roughness);
}
