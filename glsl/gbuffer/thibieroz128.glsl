// Thibieroz 2004, "Attribute Buffer": position, normal and colour. The paper's Phong model needs no more; roughness and
// metallicness are where its three targets have a channel left.
//   position       R16G16B16A16_SFLOAT  world space, metres; roughness
//   normal         A2B10G10R10_UNORM    normal * 0.5 + 0.5; 1: lit
//   base_metallic  R8G8B8A8_SRGB        base colour, metallic

#ifdef SUBPASS_GEOMETRY

void write_thibieroz128(Surface surface, vec3 base_color, float metallic) {
    target_position = vec4(as_half(surface.position_world), surface.roughness);
    target_normal = surface.lit ? vec4(surface.normal_world * 0.5 + 0.5, 1.0) : vec4(0.0);
    target_base_metallic = vec4(encode_color(base_color), metallic);
}

#else

Surface read_thibieroz128() {
    vec4 position = input_load(input_position);
    vec4 normal = input_load(input_normal);
    vec4 base_metallic = input_load(input_base_metallic);
    vec3 base_color = decode_color(base_metallic.rgb);
    return Surface(
        position.xyz, normal.a != 0.0, unit(normal.xyz * 2.0 - 1.0), position.w,
        diffuse_of(base_color, base_metallic.a), f0_of(base_color, base_metallic.a));
}

#ifdef SUBPASS_DECALS

void paint_thibieroz128(Paint paint) {
    if (is_target(TARGET_POSITION)) {
        vec4 position = input_load(input_position);
        target_position = DECAL_ROUGHNESS ? vec4(position.xyz, paint.roughness) : position;
    }
    if (is_target(TARGET_NORMAL)) {
        target_normal = DECAL_NORMAL ? vec4(paint.normal_world * 0.5 + 0.5, 1.0) : input_load(input_normal);
    }
    if (is_target(TARGET_BASE_METALLIC)) {
        target_base_metallic = painted_base_metallic(input_load(input_base_metallic), paint);
    }
}

#endif

#endif
