// What decals make of a surface, and of which channels.

// What diffuse albedo and reflectance were mixed from (surface.glsl): exact for dielectrics and metals. Between them there is more
// than one answer where colours are dark; this is the one with the least metal, after one step of a fixed point.
vec4 base_metallic_of(vec3 diffuse, vec3 f0) {
    vec3 metal = max(f0 - DIELECTRIC_F0, 0.0);
    float most_metal = max(max(metal.r, metal.g), metal.b);
    float most = most_metal + max(max(diffuse.r, diffuse.g), diffuse.b);
    float metallic = most > 0.0 ? most_metal / most : 0.0;
    return vec4(max(diffuse + f0 - DIELECTRIC_F0 * (1.0 - metallic), 0.0), metallic);
}

#ifdef SUBPASS_DECALS

layout(constant_id = ID_DECAL_BASE_COLOR) const bool DECAL_BASE_COLOR = false;
layout(constant_id = ID_DECAL_NORMAL) const bool DECAL_NORMAL = false;
layout(constant_id = ID_DECAL_ROUGHNESS) const bool DECAL_ROUGHNESS = false;
layout(constant_id = ID_DECAL_METALLIC) const bool DECAL_METALLIC = false;
layout(constant_id = ID_DECAL_TARGETS) const uint DECAL_TARGETS = 0u; // what some decal of the scene changes, by number

struct Paint {
    vec3 base_color;
    float metallic;
    float roughness;
    vec3 normal_world; // unit length
};

// A target that this decal leaves as it is, but others of its subpass change, is written as it was read.
bool is_target(uint target) {
    return (DECAL_TARGETS >> target & 1u) != 0u;
}

// Of the forms that have normal and roughness in one target.
vec4 painted_normal_roughness(vec4 stored, Paint paint) {
    if (DECAL_NORMAL) {
        stored = encode_normal_roughness(paint.normal_world, decode_roughness(stored));
    }
    return DECAL_ROUGHNESS ? with_roughness(stored, paint.roughness) : stored;
}

// Of the forms that have base colour and metallicness in one target.
vec4 painted_base_metallic(vec4 stored, Paint paint) {
    if (DECAL_BASE_COLOR) {
        stored.rgb = encode_color(paint.base_color);
    }
    if (DECAL_METALLIC) {
        stored.a = paint.metallic;
    }
    return stored;
}

#endif
