#version 450
// The box of each decal, with room to spare; a surface in it is in front of the box's far side.
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "frame.glsl"
#include "volume.glsl"
#include "decal.glsl"

layout(location = VARYING_DECAL) flat out uint varying_decal;

void main() {
    uint index = uint(gl_InstanceIndex);
    uint vertex = uint(gl_VertexIndex);
    varying_decal = index;
    if (decals[index].whole_image != 0u) {
        // As fullscreen.vert; of what is left of the box's triangles all corners are one.
        vec2 corner = vec2(vertex & 1u, vertex >> 1);
        gl_Position = vec4(vertex < 3u ? corner * 4.0 - 1.0 : vec2(-1.0), 0.0, 1.0);
        return;
    }
    vec4 row0 = decals[index].world_from_decal_rows[0];
    vec4 row1 = decals[index].world_from_decal_rows[1];
    vec4 row2 = decals[index].world_from_decal_rows[2];
    // The cube is its own mirror image: its triangles are turned back where the box is mirrored.
    vec3 corner = cube(vertex) * vec3(decals[index].handedness, 1.0, 1.0);
    vec3 center = vec3(row0.w, row1.w, row2.w);
    vec3 x = vec3(row0.x, row1.x, row2.x);
    vec3 y = vec3(row0.y, row1.y, row2.y);
    vec3 z = vec3(row0.z, row1.z, row2.z);
    float extent = 0.5 * (length(x) + length(y) + length(z));
    float room = ROOM * extent + ROOM_PIXELS * pixel_size(center + frame.forward_world.xyz * extent);
    vec3 position = center + x * (0.5 * corner.x) + y * (0.5 * corner.y) + z * (0.5 * corner.z)
        + (unit(x) * corner.x + unit(y) * corner.y + unit(z) * corner.z) * room;
    gl_Position = frame.clip_from_world * vec4(position, 1.0);
}
