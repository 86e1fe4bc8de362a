#version 450
// Poses a mesh, a vertex each: adds morph targets by weight, and takes the sum where the mean of its joints takes it. What is written are
// the vertices that every pass of the frame reads.
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"

// A square, though lists have one dimension: layers take groups in a row for a sign that images are read.
layout(local_size_x = 8, local_size_y = 8) in;

// Of all meshes that bend: positions, normals, tangents (floats), then of each vertex its influences (two words of joints, 16 bits each,
// and four weights, floats), then displacements.
layout(set = SET_FRAME, binding = BINDING_REST, std430) readonly buffer Rest {
    uint rest[];
};

// Three rows a joint; of morph targets that have a weight: the weight, and where in `rest` the displacements of positions, normals
// and tangents begin, as bits.
layout(set = SET_FRAME, binding = BINDING_POSES, std430) readonly buffer Poses {
    vec4 poses[];
};

layout(set = SET_FRAME, binding = BINDING_POSED, std430) writeonly buffer Posed {
    float posed[];
};

// Mirrors PosePush in src/gpu/shared.rs.
layout(push_constant, std430) uniform PosePush {
    uint vertices;
    uint first_source;    // in `rest`, the vertex that each of these is posed as; NONE: itself
    uint influences;      // of each vertex
    uint first_influence; // where lists begin in `rest`
    uint rest_position;
    uint rest_normal;     // NONE: there are no normals
    uint rest_tangent;    // likewise
    uint first_joint;     // in `poses`
    uint first_target;
    uint targets;
    uint position;        // where lists begin in `posed`
    uint position_stride;
    uint normal;
    uint tangent;
} push;

const uint NONE = 0xffffffffu;

vec3 read(uint first, uint vertex, uint stride) {
    uint at = first + vertex * stride;
    return uintBitsToFloat(uvec3(rest[at], rest[at + 1u], rest[at + 2u]));
}

void write(uint at, vec3 value) {
    posed[at] = value.x;
    posed[at + 1u] = value.y;
    posed[at + 2u] = value.z;
}

void main() {
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    uint written = group * 64u + gl_LocalInvocationIndex;
    if (written >= push.vertices) {
        return;
    }
    uint vertex = written;
    if (push.first_source != NONE) {
        vertex = rest[push.first_source + written];
    }
    bool has_normal = push.rest_normal != NONE;
    bool has_tangent = push.rest_tangent != NONE;
    vec3 position = read(push.rest_position, vertex, 3u);
    vec3 normal = vec3(0.0);
    vec3 tangent = vec3(0.0);
    float bitangent_sign = 1.0;
    if (has_normal) {
        normal = read(push.rest_normal, vertex, 3u);
    }
    if (has_tangent) {
        tangent = read(push.rest_tangent, vertex, 4u);
        bitangent_sign = uintBitsToFloat(rest[push.rest_tangent + vertex * 4u + 3u]);
    }
    for (uint i = 0u; i < push.targets; i++) {
        vec4 target = poses[push.first_target + i];
        uvec3 first = floatBitsToUint(target.yzw);
        if (first.x != NONE) {
            position += read(first.x, vertex, 3u) * target.x;
        }
        if (has_normal && first.y != NONE) {
            normal += read(first.y, vertex, 3u) * target.x;
        }
        if (has_tangent && first.z != NONE) {
            tangent += read(first.z, vertex, 3u) * target.x;
        }
    }
    if (push.influences > 0u) {
        vec4 row0 = vec4(0.0);
        vec4 row1 = vec4(0.0);
        vec4 row2 = vec4(0.0);
        for (uint i = 0u; i < push.influences; i++) {
            uint at = push.first_influence + (vertex * push.influences + i) * 6u;
            uvec2 pairs = uvec2(rest[at], rest[at + 1u]);
            uvec4 joints = uvec4(pairs.x & 0xffffu, pairs.x >> 16, pairs.y & 0xffffu, pairs.y >> 16);
            for (uint k = 0u; k < 4u; k++) {
                float weight = uintBitsToFloat(rest[at + 2u + k]);
                uint joint = push.first_joint + joints[k] * 3u;
                row0 += poses[joint] * weight;
                row1 += poses[joint + 1u] * weight;
                row2 += poses[joint + 2u] * weight;
            }
        }
        vec4 place = vec4(position, 1.0);
        position = vec3(dot(row0, place), dot(row1, place), dot(row2, place));
        tangent = vec3(dot(row0.xyz, tangent), dot(row1.xyz, tangent), dot(row2.xyz, tangent));
        // The inverse transpose, as in geometry.vert; of rows about as long as 1, so that small joints leave a normal its length.
        vec3 largest = max(max(abs(row0.xyz), abs(row1.xyz)), abs(row2.xyz));
        float size = max(max(max(largest.x, largest.y), largest.z), 1.17549435e-38);
        vec3 across0 = row0.xyz / size;
        vec3 across1 = row1.xyz / size;
        vec3 across2 = row2.xyz / size;
        vec3 cofactor0 = cross(across1, across2);
        vec3 cofactor1 = cross(across2, across0);
        vec3 cofactor2 = cross(across0, across1);
        float handedness = dot(across0, cofactor0) < 0.0 ? -1.0 : 1.0;
        normal = vec3(dot(cofactor0, normal), dot(cofactor1, normal), dot(cofactor2, normal)) * handedness;
        bitangent_sign *= handedness;
    }
    write(push.position + written * push.position_stride, position);
    if (has_normal) {
        write(push.normal + written * 3u, unit(normal));
    }
    if (has_tangent) {
        uint at = push.tangent + written * 4u;
        write(at, unit(tangent));
        posed[at + 3u] = bitangent_sign;
    }
}
