// Meshes around what reaches a part of the world only. Wants frame.glsl.

// How much larger than what it stands for a mesh is, as a share of its extent, so that rounding opens no gap.
const float ROOM = 0.002;
// And in pixels, since rasterisers move vertices to a grid of 1/16 at the coarsest (subPixelPrecisionBits).
const float ROOM_PIXELS = 0.1;

// The cube from -1 to 1: two triangles for each of six sides.
vec3 cube(uint vertex) {
    const vec2 corners[6] = vec2[](
        vec2(-1, -1), vec2(1, -1), vec2(1, 1), vec2(-1, -1), vec2(1, 1), vec2(-1, 1));
    uint side = vertex / 6u;
    float outwards = side < 3u ? 1.0 : -1.0;
    vec2 corner = corners[vertex % 6u];
    vec3 across = vec3(outwards, corner.x * outwards, corner.y);
    return side % 3u == 0u ? across.xyz : side % 3u == 1u ? across.zxy : across.yzx;
}

// The size of a pixel in the world at a place, metres.
float pixel_size(vec3 place) {
    float distance = max(dot(place - frame.camera_position_world.xyz, frame.forward_world.xyz), 0.0);
    float grows = mix(1.0, distance, frame.camera_position_world.w);
    return 2.0 * length(frame.down_world.xyz) * frame.inverse_size.y * grows;
}
