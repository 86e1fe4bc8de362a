// Where a fragment is, in world space.

// Fragments of a sample have places of their own, which only their own depth goes with: all else that geometry stored is of the
// pixel's centre.
vec2 fragment_place() {
#ifdef MULTISAMPLED
    if (!SAMPLE_DEPTH) {
        return floor(gl_FragCoord.xy) + 0.5;
    }
#endif
    return gl_FragCoord.xy;
}

// A point of the view plane, relative to the axis, for this fragment.
vec3 view_plane_offset_world() {
    vec2 ndc = fragment_place() * (2.0 * frame.inverse_size) - 1.0;
    return frame.right_world.xyz * ndc.x + frame.down_world.xyz * ndc.y;
}

// Where this pixel's ray is at distance 0 along the view axis.
vec3 ray_origin_world() {
    return frame.camera_position_world.xyz + view_plane_offset_world() * (1.0 - frame.camera_position_world.w);
}

// From the camera through this pixel, per metre along the view axis.
vec3 ray_world() {
    return frame.forward_world.xyz + view_plane_offset_world() * frame.camera_position_world.w;
}

// From the surface towards the viewer, unit length.
vec3 view_direction_world() {
    return -normalize(ray_world());
}

// Metres along the view axis: the projection's third row inverted, so that no matrix is needed.
float distance_of(float depth) {
    vec4 d = frame.distance_from_depth;
    return (d.x + d.y * depth) / (d.z + d.w * depth);
}

// Where this pixel's surface is.
vec3 position_world(float depth) {
    return ray_origin_world() + ray_world() * distance_of(depth);
}
