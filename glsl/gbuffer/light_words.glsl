// Light of the forms of eight words, which agree in its place: half floats, r and g in the last of `words`, b in the lower half of
// the first of `more_words`.

#ifdef SUBPASS_LIGHTING

void add_light_words(vec3 light) {
    uvec4 words = input_load(input_words);
    uvec4 more = input_load(input_more_words);
    vec3 sum = min(vec3(unpackHalf2x16(words.w), unpackHalf2x16(more.x).x) + light, vec3(65504.0));
    target_words = uvec4(words.xyz, packHalf2x16(sum.rg));
    target_more_words = uvec4(bitfieldInsert(more.x, packHalf2x16(vec2(sum.b, 0.0)), 0, 16), more.yzw);
}

#endif
