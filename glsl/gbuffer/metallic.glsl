// Metallic workflow with the channels of Smith and Einig 2015, listing 2.2:
//   depth             reversed device depth, a target of its own or the depth attachment
//   normal_roughness  normal.glsl
//   base_metallic     base colour (color.glsl), metallic
//   light             exposed light * light_scale

#ifdef SUBPASS_GEOMETRY

void write_metallic(Surface surface, vec3 base_color, float metallic) {
    write_depth();
    target_normal_roughness =
        surface.lit ? encode_normal_roughness(surface.normal_world, surface.roughness) : vec4(0.0);
    target_base_metallic = vec4(encode_color(base_color), metallic);
}

#else

Surface read_metallic() {
    vec4 normal_roughness = input_load(input_normal_roughness);
    vec4 base_metallic = input_load(input_base_metallic);
    vec3 base_color = decode_color(base_metallic.rgb);
    return Surface(
        read_position(), is_lit(normal_roughness), decode_normal(normal_roughness), decode_roughness(normal_roughness),
        diffuse_of(base_color, base_metallic.a), f0_of(base_color, base_metallic.a));
}

#ifdef SUBPASS_DECALS

void paint_metallic(Paint paint) {
    if (is_target(TARGET_NORMAL_ROUGHNESS)) {
        target_normal_roughness = painted_normal_roughness(input_load(input_normal_roughness), paint);
    }
    if (is_target(TARGET_BASE_METALLIC)) {
        target_base_metallic = painted_base_metallic(input_load(input_base_metallic), paint);
    }
}

#endif

#endif
