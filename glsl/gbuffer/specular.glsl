// Specular workflow, Smith and Einig 2015, listing 2.1: as metallic.glsl, but with
//   base_metallic  diffuse albedo, padding
//   specular       reflectance at normal incidence, padding

#ifdef SUBPASS_GEOMETRY

void write_specular(Surface surface) {
    write_metallic(surface, surface.diffuse, 0.0);
    target_specular = vec4(encode_color(surface.f0), 0.0);
}

#else

Surface read_specular() {
    Surface surface = read_metallic();
    surface.f0 = decode_color(input_load(input_specular).rgb);
    return surface;
}

#ifdef SUBPASS_DECALS

// Albedo and reflectance as products of base colour and metallicness.
vec4 painted_product(vec4 stored, vec3 product) {
    return DECAL_BASE_COLOR || DECAL_METALLIC ? vec4(encode_color(product), stored.a) : stored;
}

void paint_products(Paint paint) {
    if (is_target(TARGET_BASE_METALLIC)) {
        vec3 diffuse = diffuse_of(paint.base_color, paint.metallic);
        target_base_metallic = painted_product(input_load(input_base_metallic), diffuse);
        target_specular = painted_product(input_load(input_specular), f0_of(paint.base_color, paint.metallic));
    }
}

void paint_specular(Paint paint) {
    if (is_target(TARGET_NORMAL_ROUGHNESS)) {
        target_normal_roughness = painted_normal_roughness(input_load(input_normal_roughness), paint);
    }
    paint_products(paint);
}

#endif

#endif
