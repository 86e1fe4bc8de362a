#version 450
// The walls and ends of the space behind what faces a light (src/visible/silhouette.rs): for each edge of a mesh a wall that goes on
// for ever where one of its sides faces the light, for each triangle that does its own place and its image at an infinite distance.
// With NEAR_ENDS those own places.
// What is not there collapses to a point.
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "frame.glsl"

// Places (xyz as floats), triangles (three places) and edges (from, to, triangle, triangle) of all casters.
layout(set = SET_FRAME, binding = BINDING_CASTERS, std430) readonly buffer Casters {
    uvec4 casters[];
};

struct Instance {
    vec4 world_from_object_rows[3];
};

layout(set = SET_FRAME, binding = BINDING_CASTER_INSTANCES, std430) readonly buffer CasterInstances {
    Instance list[];
} caster_instances;

// Mirrors VolumePush in src/gpu/shared.rs.
layout(push_constant, std430) uniform VolumePush {
    vec4 light;         // place, world, and 1; the way towards a directional light, and 0
    uint first_place;   // where the mesh's are among `casters`
    uint first_triangle;
    uint first_edge;
    uint edge_vertices; // six an edge; six a triangle follow
    uint turned;        // 1: triangles are clockwise from the front
    uint unused[3];
} push;

// Surfaces are at the same places to the bit (geometry.vert).
out gl_PerVertex {
    invariant vec4 gl_Position;
#ifndef NEAR_ENDS
    // What is before the near plane is in front of every surface. Walls and far ends are not clipped at the far plane, and so not at
    // the near one either (depthClampEnable), unless it is done here: depths of huge triangles that go past the camera would be none.
    float gl_ClipDistance[1];
#endif
};

const uint NO_TRIANGLE = 0xffffffffu;

vec3 place_world(uint place) {
    vec4 row0 = caster_instances.list[gl_InstanceIndex].world_from_object_rows[0];
    vec4 row1 = caster_instances.list[gl_InstanceIndex].world_from_object_rows[1];
    vec4 row2 = caster_instances.list[gl_InstanceIndex].world_from_object_rows[2];
    vec4 position = vec4(uintBitsToFloat(casters[push.first_place + place].xyz), 1.0);
    return vec3(dot(row0, position), dot(row1, position), dot(row2, position));
}

// From the same three places in the same order whoever asks, so that a triangle's walls agree with its ends.
bool faces_light(uint triangle) {
    uvec4 places = casters[push.first_triangle + triangle];
    vec3 a = place_world(places.x);
    vec3 b = place_world(places.y);
    vec3 c = place_world(places.z);
    vec3 to_light = push.light.xyz - a * push.light.w;
    precise float side = dot(cross(b - a, c - a), to_light);
    return (side > 0.0) != (push.turned != 0u);
}

// The place, or where light that passes it goes.
vec4 clip_place(uint place, bool at_infinity) {
    vec3 position = place_world(place);
    if (at_infinity) {
        return frame.clip_from_world * vec4(position * push.light.w - push.light.xyz, 0.0);
    }
    return frame.clip_from_world * vec4(position, 1.0);
}

// Whether the far plane cuts a triangle off, as it does surfaces.
bool is_cut_off(uvec3 places) {
    return clip_place(places.x, false).z < 0.0 || clip_place(places.y, false).z < 0.0 || clip_place(places.z, false).z < 0.0;
}

// A corner of a triangle's near end, as it is seen from the light, or of its far end, which goes the other way round.
vec4 end_corner(uvec3 places, uint corner, bool is_far) {
    bool goes_back = is_far != (push.turned != 0u);
    return clip_place(places[goes_back && corner != 0u ? 3u - corner : corner], is_far);
}

#ifdef NEAR_ENDS
// The triangles themselves, clipped as surfaces are, and so of the same depth to the bit. Those that the far plane would cut off are
// among the others, which it does not cut: what is beyond it counts too.
void main() {
    uint vertex = uint(gl_VertexIndex);
    uvec3 places = casters[push.first_triangle + vertex / 3u].xyz;
    bool is_here = faces_light(vertex / 3u) && !is_cut_off(places);
    gl_Position = is_here ? end_corner(places, vertex % 3u, false) : vec4(0.0, 0.0, 0.0, 1.0);
}
#else
// How far the near end of a triangle that the far plane cuts lies behind the triangle itself, which is not in its own shadow: a cut
// triangle is another, and a rasteriser rounds its depths otherwise: by units in the last place of its nearest corner's, times how
// far beyond the screen it goes.
float behind(uvec3 places) {
    float nearest = 0.0;
    for (uint i = 0u; i < 3u; i++) {
        vec4 clip = clip_place(places[i], false);
        nearest = max(nearest, clip.w > clip.z ? clip.z / clip.w : 1.0);
    }
    return nearest / 262144.0 + 1.0 / 8388608.0;
}

vec4 end(uint triangle, uint corner) {
    uvec3 places = casters[push.first_triangle + triangle].xyz;
    bool is_far = corner >= 3u;
    if (!faces_light(triangle) || !(is_far || is_cut_off(places))) {
        return vec4(0.0, 0.0, 0.0, 1.0);
    }
    vec4 position = end_corner(places, corner % 3u, is_far);
    position.z -= is_far ? 0.0 : behind(places) * position.w;
    return position;
}

vec4 wall_corner(uint vertex) {
    uvec4 edge = casters[push.first_edge + vertex / 6u];
    bool first = faces_light(edge.z);
    bool second = edge.w != NO_TRIANGLE && faces_light(edge.w);
    if (first == second) {
        return vec4(0.0, 0.0, 0.0, 1.0);
    }
    // Counter-clockwise from outside: from, from at infinity, to at infinity; from, to at infinity, to.
    const uint ends[6] = uint[](0u, 2u, 3u, 0u, 3u, 1u);
    uint end = ends[vertex % 6u];
    bool is_to = ((end & 1u) != 0u) != (first == (push.turned != 0u));
    return clip_place(is_to ? edge.y : edge.x, end >= 2u);
}

void main() {
    uint vertex = uint(gl_VertexIndex);
    uint of_end = vertex - push.edge_vertices;
    gl_Position = vertex < push.edge_vertices ? wall_corner(vertex) : end(of_end / 6u, of_end % 6u);
    gl_ClipDistance[0] = gl_Position.w - gl_Position.z;
}
#endif
