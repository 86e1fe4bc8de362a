// A box that paints what is in it. Mirrors DecalData in src/gpu/shared.rs.

struct Decal {
    vec4 world_from_decal_rows[3]; // of the cube from -0.5 to 0.5
    vec4 decal_from_world_rows[3];
    vec4 opacity;                  // of base colour, normal, roughness, metallicness
    vec3 inverse_falloff;          // of the box's size, along each axis
    float handedness;              // of its axes: 1, or -1
    vec2 facing;                   // share by the cosine between normal and +Z: cosine * x + y, held to 0 to 1
    uint whole_image;              // not 0: drawn as a triangle over the image
    uint padding;
};

layout(set = SET_FRAME, binding = BINDING_DECALS, std430) readonly buffer Decals {
    Decal decals[];
};

vec3 decal_axis_world(Decal decal, int axis) {
    return unit(vec3(
        decal.world_from_decal_rows[0][axis], decal.world_from_decal_rows[1][axis], decal.world_from_decal_rows[2][axis]));
}
