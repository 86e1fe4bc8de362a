// "Deferred versus Multi-Pass Forward Shading" (dissertation), 4.5.1: three targets of R16G16B16A16_SFLOAT, nothing encoded.
//   position          view space, metres; roughness
//   normal            view space; 1: lit
//   base_metallic     base colour, linear; metallic

#ifdef SUBPASS_GEOMETRY

void write_dissertation192(Surface surface, vec3 base_color, float metallic) {
    mat3 axes = world_from_view();
    target_position = vec4(as_half((surface.position_world - frame.camera_position_world.xyz) * axes), surface.roughness);
    target_normal = surface.lit ? vec4(surface.normal_world * axes, 1.0) : vec4(0.0);
    target_base_metallic = vec4(base_color, metallic);
}

#else

Surface read_dissertation192() {
    mat3 axes = world_from_view();
    vec4 position = input_load(input_position);
    vec4 normal = input_load(input_normal);
    vec4 base_metallic = input_load(input_base_metallic);
    return Surface(
        frame.camera_position_world.xyz + axes * position.xyz, normal.a != 0.0, unit(axes * normal.xyz), position.w,
        diffuse_of(base_metallic.rgb, base_metallic.a), f0_of(base_metallic.rgb, base_metallic.a));
}

#ifdef SUBPASS_DECALS

void paint_dissertation192(Paint paint) {
    if (is_target(TARGET_POSITION)) {
        vec4 position = input_load(input_position);
        target_position = DECAL_ROUGHNESS ? vec4(position.xyz, paint.roughness) : position;
    }
    if (is_target(TARGET_NORMAL)) {
        vec4 normal = input_load(input_normal);
        target_normal = DECAL_NORMAL ? vec4(paint.normal_world * world_from_view(), normal.a) : normal;
    }
    if (is_target(TARGET_BASE_METALLIC)) {
        target_base_metallic = painted_base_metallic(input_load(input_base_metallic), paint);
    }
}

#endif

#endif
