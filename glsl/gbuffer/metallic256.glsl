// Smith and Einig 2015, listing 2.7: position stored, everything linear. Eight words in two R32G32B32A32_UINT:
//   words       position x, y, z (float); light r, g (half)
//   more_words  light b, normal x (half); normal y, z (half); roughness, metallic (half); base colour (b10g11r11)
// The sign of the roughness, which has none, says that there is a surface.

#ifdef SUBPASS_GEOMETRY

void write_metallic256(Surface surface, vec3 base_color, float metallic, vec4 light) {
    uint covered = light.a > 0.0 ? 0x8000u : 0u;
    target_words = uvec4(floatBitsToUint(surface.position_world), packHalf2x16(light.rg));
    target_more_words = uvec4(
        packHalf2x16(vec2(light.b, surface.lit ? surface.normal_world.x : 0.0)),
        surface.lit ? packHalf2x16(surface.normal_world.yz) : 0u,
        packHalf2x16(vec2(surface.roughness, metallic)) | covered, b10g11r11_of(base_color));
}

#else

Surface read_metallic256() {
    uvec4 words = input_load(input_words);
    uvec4 more = input_load(input_more_words);
    vec3 normal = vec3(unpackHalf2x16(more.x).y, unpackHalf2x16(more.y));
    vec2 roughness_metallic = abs(unpackHalf2x16(more.z));
    vec3 base_color = from_b10g11r11(more.w);
    return Surface(
        uintBitsToFloat(words.xyz), normal != vec3(0.0), unit(normal), roughness_metallic.x,
        diffuse_of(base_color, roughness_metallic.y), f0_of(base_color, roughness_metallic.y));
}

vec4 read_light_metallic256() {
    uvec4 more = input_load(input_more_words);
    return vec4(
        unpackHalf2x16(input_load(input_words).w), unpackHalf2x16(more.x).x, (more.z & 0x8000u) != 0u ? 1.0 : 0.0);
}

vec4 base_metallic_metallic256() {
    uvec4 more = input_load(input_more_words);
    return vec4(from_b10g11r11(more.w), abs(unpackHalf2x16(more.z).y));
}

#ifdef SUBPASS_DECALS

void paint_metallic256(Paint paint) {
    uvec4 more = input_load(input_more_words);
    if (DECAL_NORMAL) {
        more.x = bitfieldInsert(more.x, packHalf2x16(vec2(paint.normal_world.x, 0.0)), 16, 16);
        more.y = packHalf2x16(paint.normal_world.yz);
    }
    if (DECAL_ROUGHNESS) {
        // Its sign stays.
        more.z = bitfieldInsert(more.z, packHalf2x16(vec2(paint.roughness, 0.0)), 0, 15);
    }
    if (DECAL_METALLIC) {
        more.z = bitfieldInsert(more.z, packHalf2x16(vec2(paint.metallic, 0.0)), 16, 16);
    }
    if (DECAL_BASE_COLOR) {
        more.w = b10g11r11_of(paint.base_color);
    }
    target_more_words = more;
}

#endif

#endif
