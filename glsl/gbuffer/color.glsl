// Gamma of stored colour. By format: the attachment encodes sRGB, or holds floats.

layout(constant_id = ID_GAMMA) const uint GAMMA = GAMMA_BY_FORMAT;

vec3 encode_color(vec3 linear) {
    if (GAMMA == GAMMA_2_2) {
        return pow(max(linear, 0.0), vec3(1.0 / 2.2));
    }
    return GAMMA == GAMMA_2_0 ? sqrt(max(linear, 0.0)) : linear; // Smith and Einig 2015, listing 2.4
}

vec3 decode_color(vec3 stored) {
    if (GAMMA == GAMMA_2_2) {
        return pow(stored, vec3(2.2)); // listing 2.3
    }
    return GAMMA == GAMMA_2_0 ? stored * stored : stored;
}
