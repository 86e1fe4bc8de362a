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

#endif
