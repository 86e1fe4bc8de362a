// Bits where they lower the error most (tests/packing.rs is the search), and light that one stage reads and adds to, so that
// nothing is blended:
//   depth       the depth attachment
//   words       R32G32_UINT: normal 11 + 11 (octahedral), roughness 9; base colour 9 + 9 + 9 (hyperbola), metallic 6
//   light_word  R32_UINT: exposed light * light_scale (e5b9g9r9); where lights are added one by one R32G32_UINT, 21 bits each

uvec2 light_word_of(vec3 light) {
    return LIGHT_ADDED ? sum_words_of(light) : uvec2(e5b9g9r9_of(light), 0u);
}

vec3 from_light_word(uvec2 word) {
    return LIGHT_ADDED ? from_sum_words(word) : from_e5b9g9r9(word.x);
}

const float HALF_STEPS_11 = 1023.0;

// Stands for a gamma: steps are as shading and the tone curve want them, and either way is a division instead of a power.
const float HYPERBOLA = 0.7;

vec3 hyperbola_of(vec3 linear) {
    vec3 x = clamp(linear, 0.0, 1.0);
    return x * (1.0 + HYPERBOLA) / (x + HYPERBOLA);
}

vec3 from_hyperbola(vec3 t) {
    return t * HYPERBOLA / (1.0 + HYPERBOLA - t);
}

#ifdef SUBPASS_GEOMETRY

void write_packed128(Surface surface, vec3 base_color, float metallic, vec4 light) {
    uvec2 normal = surface.lit ? octahedral_codes(surface.normal_world, HALF_STEPS_11) : uvec2(0u);
    uvec3 color = uvec3(hyperbola_of(base_color) * 511.0 + 0.5);
    uvec2 rest = uvec2(clamp(vec2(surface.roughness, metallic), 0.0, 1.0) * vec2(511.0, 63.0) + 0.5);
    // The metallicness' highest bit is where the first word has room.
    target_words = uvec4(
        normal.x | normal.y << 11 | rest.x << 22 | rest.y >> 5 << 31,
        color.r | color.g << 9 | color.b << 18 | rest.y << 27, 0u, 0u);
    if (LIGHT_READ) {
        target_light_word = light_word_of(light.rgb);
    }
}

#else

Surface read_packed128() {
    uvec2 words = input_load(input_words).xy;
    uvec2 normal = uvec2(words.x & 0x7ffu, words.x >> 11 & 0x7ffu);
    vec3 base_color = from_hyperbola(vec3(words.y & 511u, words.y >> 9 & 511u, words.y >> 18 & 511u) / 511.0);
    float metallic = float(words.x >> 31 << 5 | words.y >> 27) / 63.0;
    return Surface(
        read_position(), normal != uvec2(0u), direction_from_octahedral(from_codes(normal, HALF_STEPS_11)),
        float(words.x >> 22 & 511u) / 511.0, diffuse_of(base_color, metallic), f0_of(base_color, metallic));
}

vec4 read_light_packed128(bool tell_background) {
    float covered = 1.0;
    if (tell_background) {
        covered = input_load(input_depth).r > 0.0 ? 1.0 : 0.0;
    }
    return vec4(from_light_word(input_load(input_light_word).xy), covered);
}

vec4 base_metallic_packed128() {
    uvec2 words = input_load(input_words).xy;
    vec3 stored = vec3(words.y & 511u, words.y >> 9 & 511u, words.y >> 18 & 511u) / 511.0;
    return vec4(from_hyperbola(stored), float(words.x >> 31 << 5 | words.y >> 27) / 63.0);
}

#ifdef SUBPASS_DECALS

void paint_packed128(Paint paint) {
    uvec2 words = input_load(input_words).xy;
    uvec2 rest = uvec2(clamp(vec2(paint.roughness, paint.metallic), 0.0, 1.0) * vec2(511.0, 63.0) + 0.5);
    if (DECAL_NORMAL) {
        uvec2 normal = octahedral_codes(paint.normal_world, HALF_STEPS_11);
        words.x = bitfieldInsert(words.x, normal.x | normal.y << 11, 0, 22);
    }
    if (DECAL_ROUGHNESS) {
        words.x = bitfieldInsert(words.x, rest.x, 22, 9);
    }
    if (DECAL_METALLIC) {
        words = uvec2(bitfieldInsert(words.x, rest.y >> 5, 31, 1), bitfieldInsert(words.y, rest.y, 27, 5));
    }
    if (DECAL_BASE_COLOR) {
        uvec3 color = uvec3(hyperbola_of(paint.base_color) * 511.0 + 0.5);
        words.y = bitfieldInsert(words.y, color.r | color.g << 9 | color.b << 18, 0, 27);
    }
    target_words = uvec4(words, 0u, 0u);
}

#endif

#ifdef SUBPASS_LIGHTING

void add_light_packed128(vec3 light) {
    target_light_word = light_word_of(from_light_word(input_load(input_light_word).xy) + light);
}

#endif

#endif
