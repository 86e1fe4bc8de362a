// Bits where they lower the error most; blending is not needed, since one stage reads light and adds to it (src/plan/layout.rs
// says how the numbers were found).
//   depth       the depth attachment
//   words       R32G32_UINT: normal 12 + 12 (octahedral), roughness 8; base colour 9 + 10 + 9 (gamma 2), metallic 4
//   light_word  R32_UINT: exposed light * light_scale (e5b9g9r9)

#ifdef SUBPASS_GEOMETRY

void write_packed128(Surface surface, vec3 base_color, float metallic, vec4 light) {
    uvec2 normal = surface.lit ? octahedral_codes(surface.normal_world, HALF_STEPS_12) : uvec2(0u);
    uvec3 color = uvec3(sqrt(clamp(base_color, 0.0, 1.0)) * vec3(511.0, 1023.0, 511.0) + 0.5);
    uvec2 rest = uvec2(clamp(vec2(surface.roughness, metallic), 0.0, 1.0) * vec2(255.0, 15.0) + 0.5);
    target_words = uvec4(
        normal.x | normal.y << 12 | rest.x << 24, color.r | color.g << 9 | color.b << 19 | rest.y << 28, 0u, 0u);
    if (LIGHT_READ) {
        target_light_word = e5b9g9r9_of(light.rgb);
    }
}

#else

Surface read_packed128() {
    uvec2 words = subpassLoad(input_words).xy;
    uvec2 normal = uvec2(words.x & 0xfffu, words.x >> 12 & 0xfffu);
    vec3 root = vec3(words.y & 511u, words.y >> 9 & 1023u, words.y >> 19 & 511u) / vec3(511.0, 1023.0, 511.0);
    vec3 base_color = root * root;
    float metallic = float(words.y >> 28) / 15.0;
    return Surface(
        read_position(), normal != uvec2(0u), direction_from_octahedral(from_codes(normal, HALF_STEPS_12)),
        float(words.x >> 24) / 255.0, diffuse_of(base_color, metallic), f0_of(base_color, metallic));
}

vec4 read_light_packed128() {
    float covered = subpassLoad(input_depth).r > 0.0 ? 1.0 : 0.0;
    return vec4(from_e5b9g9r9(subpassLoad(input_light_word).x), covered);
}

#endif
