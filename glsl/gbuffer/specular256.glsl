// Smith and Einig 2015, listing 2.8: as metallic256.glsl, but with colours of their own for both workflows' sake.
//   words       position x, y, z (float); light r, g (half)
//   more_words  light b, roughness (half); normal * 0.5 + 0.5, diffuse albedo, reflectance at normal incidence (b10g11r11)

#ifdef SUBPASS_GEOMETRY

void write_specular256(Surface surface, vec4 light) {
    uint covered = light.a > 0.0 ? 0x80000000u : 0u;
    target_words = uvec4(floatBitsToUint(surface.position_world), packHalf2x16(light.rg));
    target_more_words = uvec4(
        packHalf2x16(vec2(light.b, surface.roughness)) | covered,
        surface.lit ? b10g11r11_of(surface.normal_world * 0.5 + 0.5) : 0u, b10g11r11_of(surface.diffuse),
        b10g11r11_of(surface.f0));
}

#else

Surface read_specular256() {
    uvec4 more = input_load(input_more_words);
    return Surface(
        uintBitsToFloat(input_load(input_words).xyz), more.y != 0u, unit(from_b10g11r11(more.y) * 2.0 - 1.0),
        abs(unpackHalf2x16(more.x).y), from_b10g11r11(more.z), from_b10g11r11(more.w));
}

vec4 read_light_specular256() {
    uint word = input_load(input_more_words).x;
    return vec4(
        unpackHalf2x16(input_load(input_words).w), unpackHalf2x16(word).x, (word & 0x80000000u) != 0u ? 1.0 : 0.0);
}

#ifdef SUBPASS_DECALS

void paint_specular256(Paint paint) {
    uvec4 more = input_load(input_more_words);
    if (DECAL_ROUGHNESS) {
        // Its sign stays.
        more.x = bitfieldInsert(more.x, packHalf2x16(vec2(paint.roughness, 0.0)), 16, 15);
    }
    if (DECAL_NORMAL) {
        more.y = b10g11r11_of(paint.normal_world * 0.5 + 0.5);
    }
    if (DECAL_BASE_COLOR || DECAL_METALLIC) {
        more.z = b10g11r11_of(diffuse_of(paint.base_color, paint.metallic));
        more.w = b10g11r11_of(f0_of(paint.base_color, paint.metallic));
    }
    target_more_words = more;
}

#endif

#endif
