// Koonce 2007, 19.6.1: normals in view space, two channels, the third by its sign; four targets of 32 bits. Lighting keeps
// diffuse and specular light apart, and albedo is applied once, in the last stage (19.7.3).
//   depth           R32_SFLOAT      reversed device depth
//   normal          R8G8B8A8_UNORM  view space x and y * 0.5 + 0.5, roughness; 1: lit
//   base_metallic   R8G8B8A8_SRGB   diffuse albedo, padding
//   specular        R8G8B8A8_SRGB   reflectance at normal incidence, padding
//   light           diffuse light, times light_scale: albedo is still to be applied
//   specular_light  all other light, likewise

#ifdef SUBPASS_GEOMETRY

void write_rasa128(Surface surface) {
    vec3 normal_view = surface.normal_world * world_from_view();
    write_depth();
    target_normal = surface.lit ? vec4(normal_view.xy * 0.5 + 0.5, surface.roughness, 1.0) : vec4(0.0);
    target_base_metallic = vec4(encode_color(surface.diffuse), 0.0);
    target_specular = vec4(encode_color(surface.f0), 0.0);
}

#else

Surface read_rasa128() {
    vec4 normal = input_load(input_normal);
    vec2 xy = normal.xy * 2.0 - 1.0;
    vec3 normal_view = vec3(xy, sqrt(max(1.0 - dot(xy, xy), 0.0)));
    return Surface(
        read_position(), normal.a != 0.0, unit(world_from_view() * normal_view), normal.z,
        decode_color(input_load(input_base_metallic).rgb), decode_color(input_load(input_specular).rgb));
}

#ifdef SUBPASS_DECALS

void paint_rasa128(Paint paint) {
    if (is_target(TARGET_NORMAL)) {
        vec4 normal = input_load(input_normal);
        if (DECAL_NORMAL) {
            normal.xy = (paint.normal_world * world_from_view()).xy * 0.5 + 0.5;
        }
        target_normal = DECAL_ROUGHNESS ? vec4(normal.xy, paint.roughness, normal.a) : normal;
    }
    paint_products(paint);
}

#endif

#endif
