#version 450
// A mesh around what a light reaches, drawn once for each light. Meshes are convex, closed, and counter-clockwise from
// outside; they hold what they stand for with room to spare.
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "frame.glsl"
#include "light/punctual.glsl"
#include "volume.glsl"

layout(constant_id = ID_VOLUME_SHAPE) const uint VOLUME_SHAPE = VOLUME_SPHERE;

layout(set = SET_FRAME, binding = BINDING_VOLUMES, std430) readonly buffer Volumes {
    uint volumes[]; // the light of each instance
};

layout(location = VARYING_LIGHT) flat out uint varying_light;

out gl_PerVertex {
    vec4 gl_Position;
};
// Mask and light are to cover the same pixels.
invariant gl_Position;

// An icosahedron around the unit sphere: two poles, and two rings of five corners between them.
const float ICOSAHEDRON_RADIUS = 1.2584086; // from the centre to the corners, where faces touch the sphere
const uint ICOSAHEDRON_SIDES = 5u;

// Ring 0 and 3 are the poles. The upper and the lower ring are turned by half a side.
vec3 icosahedron_corner(uint ring, uint side) {
    float angle = (float(side % ICOSAHEDRON_SIDES) + 0.5 * float(ring & 1u)) * (2.0 * PI / float(ICOSAHEDRON_SIDES));
    float height = 1.0 / sqrt(5.0);
    if (ring == 0u || ring == 3u) {
        return vec3(0.0, 0.0, ring == 0u ? 1.0 : -1.0);
    }
    return vec3(2.0 * height * vec2(cos(angle), sin(angle)), ring == 1u ? height : -height);
}

// Four triangles for each of five sides, from pole to pole.
vec3 icosahedron(uint vertex) {
    const uvec2 corners[12] = uvec2[]( // ring, how many sides further
        uvec2(0, 0), uvec2(1, 0), uvec2(1, 1),
        uvec2(1, 0), uvec2(2, 1), uvec2(1, 1),
        uvec2(1, 0), uvec2(2, 0), uvec2(2, 1),
        uvec2(2, 0), uvec2(3, 0), uvec2(2, 1));
    uvec2 corner = corners[vertex % 12u];
    return icosahedron_corner(corner.x, vertex / 12u + corner.y);
}

// A pyramid around a cone that opens along +z from the origin to z = 1 and there has the radius 1: for each side a
// triangle of its mantle and one of its base.
const uint PYRAMID_SIDES = 8u;

vec3 pyramid(uint vertex) {
    uint corner = vertex % 6u;
    if (corner == 0u || corner == 3u) {
        return vec3(0.0, 0.0, corner == 0u ? 0.0 : 1.0);
    }
    uint side = (vertex / 6u + uint(corner == 1u || corner == 5u)) % PYRAMID_SIDES;
    float angle = float(side) * (2.0 * PI / float(PYRAMID_SIDES));
    return vec3(vec2(cos(angle), sin(angle)) / cos(PI / float(PYRAMID_SIDES)), 1.0);
}

// How much further out than a light its mesh is, metres.
float room(Light light, float extent) {
    return ROOM * extent + ROOM_PIXELS * pixel_size(light.place.xyz + frame.forward_world.xyz * extent);
}

vec3 sphere_position_world(Light light, uint vertex) {
    float range = 1.0 / light.place.w;
    return light.place.xyz + icosahedron(vertex) * ((range + room(light, range)) * ICOSAHEDRON_RADIUS);
}

vec3 cone_position_world(Light light, uint vertex) {
    float range = 1.0 / light.place.w;
    vec3 axis = light.direction_world;
    // KHR_lights_punctual's offset is -cos(outer) * scale.
    float cosine = clamp(-light.spot_offset / light.edge, 0.0, 1.0);
    float sine = sqrt(max(1.0 - cosine * cosine, 1e-6));
    // Drawn back along its axis, the cone's mantle moves outwards.
    float back = room(light, range) / sine;
    float length = back + range + room(light, range);
    vec3 right = unit(cross(axis, abs(axis.y) < 0.5 ? vec3(0.0, 1.0, 0.0) : vec3(1.0, 0.0, 0.0)));
    vec3 corner = pyramid(vertex) * vec3(vec2(length * sine / cosine), length);
    return light.place.xyz + mat3(right, cross(axis, right), axis) * corner - axis * back;
}

vec3 box_position_world(Light light, uint vertex) {
    vec3 half_size = light.half_size + room(light, length(light.half_size));
    vec3 right = cross(light.direction_world, light.up_world);
    return light.place.xyz + mat3(right, light.up_world, -light.direction_world) * (cube(vertex) * half_size);
}

void main() {
    uint index = uint(gl_InstanceIndex);
    if (VOLUME_SHAPE != VOLUME_OF_INSTANCE) {
        index = volumes[gl_InstanceIndex];
    }
    varying_light = index;
    uint vertex = uint(gl_VertexIndex);
    vec3 position;
    if (VOLUME_SHAPE == VOLUME_SCREEN || VOLUME_SHAPE == VOLUME_OF_INSTANCE) {
        // As fullscreen.vert.
        vec2 corner = vec2(vertex & 1u, vertex >> 1);
        gl_Position = vec4(corner * 4.0 - 1.0, 0.0, 1.0);
        return;
    } else if (VOLUME_SHAPE == VOLUME_SPHERE) {
        position = sphere_position_world(lights[index], vertex);
    } else if (VOLUME_SHAPE == VOLUME_CONE) {
        position = cone_position_world(lights[index], vertex);
    } else {
        position = box_position_world(lights[index], vertex);
    }
    gl_Position = frame.clip_from_world * vec4(position, 1.0);
}
