// Floats of 16 bits in targets, and unsigned ones of less in words.

// Held to what a half float can be: what is beyond may be stored as infinity, of which light is no number.
vec3 as_half(vec3 v) {
    return clamp(v, -65504.0, 65504.0);
}

// A half float's positive part without its last bits, to the nearest; `most` is the greatest finite code.
uint short_float(float x, uint dropped, uint most) {
    uint h = packHalf2x16(vec2(clamp(x, 0.0, 65504.0), 0.0));
    return min((h + (1u << (dropped - 1u)) - 1u + (h >> dropped & 1u)) >> dropped, most);
}

// As B10G11R11_UFLOAT_PACK32: 5 bits of exponent; 6, 6 and 5 of mantissa.
uint b10g11r11_of(vec3 v) {
    return short_float(v.x, 4u, 0x7bfu) | short_float(v.y, 4u, 0x7bfu) << 11 | short_float(v.z, 5u, 0x3dfu) << 22;
}

vec3 from_b10g11r11(uint word) {
    return vec3(unpackHalf2x16((word & 0x7ffu) << 4 | (word >> 11 & 0x7ffu) << 20), unpackHalf2x16(word >> 22 << 5).x);
}

// As E5B9G9R9_UFLOAT_PACK32 (Vulkan specification, "Shared exponent to RGB"): 9 bits of mantissa each, one exponent.
uint e5b9g9r9_of(vec3 v) {
    vec3 c = clamp(v, 0.0, 65408.0);
    float most = max(max(c.x, c.y), max(c.z, 1.52587890625e-5));
    int exponent = clamp(int(floatBitsToUint(most) >> 23) - 127 + 16, 0, 31);
    float step_ = exp2(float(exponent - 24));
    if (floor(most / step_ + 0.5) == 512.0) {
        exponent += 1;
        step_ *= 2.0;
    }
    uvec3 m = uvec3(floor(c / step_ + 0.5));
    return m.x | m.y << 9 | m.z << 18 | uint(exponent) << 27;
}

vec3 from_e5b9g9r9(uint word) {
    return vec3(word & 511u, word >> 9 & 511u, word >> 18 & 511u) * exp2(float(word >> 27) - 24.0);
}
