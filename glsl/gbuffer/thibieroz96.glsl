// Thibieroz 2004, "Optimized MRT Configuration": what the paper's model needs and nothing else. There is no room for roughness
// and metallicness, so that every surface is a dielectric with the paper's highlight.
//   position       R16G16_SFLOAT   world space x and y, metres
//   position_z     R16_SFLOAT      z
//   base_metallic  R8G8B8A8_SRGB   base colour; normal z * 0.5 + 0.5
//   normal_xy      R8G8_UNORM      normal x and y likewise

// The Blinn-Phong exponent 8 of the paper's shading pass, as roughness: alpha^2 = 2 / (exponent + 2) (Walter et al. 2007, 5.2).
const float THIBIEROZ_ROUGHNESS = 0.668740;

#ifdef SUBPASS_GEOMETRY

void write_thibieroz96(Surface surface, vec3 base_color) {
    vec3 normal = surface.lit ? surface.normal_world * 0.5 + 0.5 : vec3(0.0);
    target_position = vec4(as_half(surface.position_world).xy, 0.0, 0.0);
    target_position_z = as_half(surface.position_world).z;
    target_base_metallic = vec4(encode_color(base_color), normal.z);
    target_normal_xy = normal.xy;
}

#else

Surface read_thibieroz96() {
    vec4 base = input_load(input_base_metallic);
    vec3 normal = vec3(input_load(input_normal_xy).xy, base.a);
    vec3 position = vec3(input_load(input_position).xy, input_load(input_position_z).x);
    return Surface(
        position, normal != vec3(0.0), unit(normal * 2.0 - 1.0), THIBIEROZ_ROUGHNESS, decode_color(base.rgb),
        vec3(DIELECTRIC_F0));
}

#ifdef SUBPASS_DECALS

void paint_thibieroz96(Paint paint) {
    vec3 normal = paint.normal_world * 0.5 + 0.5;
    if (is_target(TARGET_BASE_METALLIC)) {
        vec4 base = input_load(input_base_metallic);
        vec3 color = DECAL_BASE_COLOR ? encode_color(paint.base_color) : base.rgb;
        target_base_metallic = vec4(color, DECAL_NORMAL ? normal.z : base.a);
    }
    if (is_target(TARGET_NORMAL_XY)) {
        target_normal_xy = DECAL_NORMAL ? normal.xy : input_load(input_normal_xy).xy;
    }
}

#endif

#endif
