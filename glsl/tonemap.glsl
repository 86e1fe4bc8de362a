// From exposed linear light to the output: tone curve, then dither. Linear Rec.709 in and out; what exceeds the
// output's range is left to its format.

layout(constant_id = ID_TONEMAP) const uint TONEMAP = TONEMAP_NEUTRAL;
layout(constant_id = ID_DITHER) const bool DITHER = false;
layout(constant_id = ID_FLOAT_OUTPUT) const bool FLOAT_OUTPUT = false;
layout(constant_id = ID_BACKGROUND) const bool BACKGROUND = false;
layout(constant_id = ID_BACKGROUND_RED) const float BACKGROUND_RED = 0.0;
layout(constant_id = ID_BACKGROUND_GREEN) const float BACKGROUND_GREEN = 0.0;
layout(constant_id = ID_BACKGROUND_BLUE) const float BACKGROUND_BLUE = 0.0;

const float LARGEST = 3.4028235e38;

// Khronos PBR Neutral Tone Mapper, specification 2024: colours below 0.8 keep hue and saturation.
vec3 tonemap_neutral(vec3 color) {
    const float fresnel = 0.04;
    const float start = 0.8 - fresnel;
    const float desaturation = 0.15;

    // Both pieces of the curve meet their neighbours where their argument is clamped, so that no branch is needed:
    // the toe is `fresnel` from 2 * fresnel on, and at `start` compressed is peak and white is 0.
    float low = min(2.0 * fresnel, min(color.r, min(color.g, color.b)));
    color -= low - low * low / (4.0 * fresnel);
    float peak = max(start, max(color.r, max(color.g, color.b)));
    const float room = 1.0 - start;
    float compressed = 1.0 - room * room / (peak - start + room);
    float white = 1.0 - 1.0 / (desaturation * (peak - compressed) + 1.0);
    return mix(color * (compressed / peak), vec3(compressed), white);
}

// ACES reference rendering and sRGB output transforms as fitted by Stephen Hill (BakingLab, ACES.hlsl, 2016).
// The matrices go from Rec.709 to the fit's space and back; columns here are the source's rows, hence `v * M`.
// The curve of 0 is below 0, and saturated colours leave Rec.709: no display shows less than no light.
vec3 tonemap_aces(vec3 color) {
    const mat3 fit_from_rec709 = mat3(
        0.59719, 0.35458, 0.04823,
        0.07600, 0.90834, 0.01566,
        0.02840, 0.13383, 0.83777);
    const mat3 rec709_from_fit = mat3(
        1.60475, -0.53108, -0.07367,
        -0.10208, 1.10813, -0.00605,
        -0.00327, -0.07276, 1.07602);
    vec3 x = min(color, 1e18) * fit_from_rec709; // whose square is a number
    vec3 a = x * (x + 0.0245786) - 0.000090537;
    vec3 b = x * (0.983729 * x + 0.4329510) + 0.238081;
    return max((a / b) * rec709_from_fit, 0.0);
}

// Reinhard et al. 2002, "Photographic Tone Reproduction for Digital Images", equation 3, per channel.
vec3 tonemap_reinhard(vec3 color) {
    return color / (1.0 + color);
}

vec3 tonemap(vec3 color) {
    // What overflowed is held to the largest number: curves divide, and infinity over infinity is no number.
    color = clamp(color, 0.0, LARGEST);
    if (TONEMAP == TONEMAP_NEUTRAL) {
        return tonemap_neutral(color);
    }
    if (TONEMAP == TONEMAP_ACES) {
        return tonemap_aces(color);
    }
    if (TONEMAP == TONEMAP_REINHARD) {
        return tonemap_reinhard(color);
    }
    return color;
}

#include "srgb.glsl"

// Half a step either way of an 8-bit sRGB output, in the order of Bayer's 8 by 8 matrix (Bayer 1973), whose entry
// interleaves the bits of x ^ y and y, the lowest bits being the most significant.
vec3 dither(vec3 linear) {
    uvec2 pixel = uvec2(gl_FragCoord.xy);
    uint x = pixel.x ^ pixel.y;
    uint y = pixel.y;
    uint entry = (x & 1u) << 5 | (y & 1u) << 4 | (x & 2u) << 2 | (y & 2u) << 1 | (x & 4u) >> 1 | (y & 4u) >> 2;
    float steps = (float(entry) + 0.5) / 64.0 - 0.5;
    vec3 srgb = srgb_from_linear(clamp(linear, 0.0, 1.0));
    return linear_from_srgb(clamp(srgb + steps / 255.0, 0.0, 1.0));
}

// What an output of 8 bits keeps of display light, rounding aside; one of floats keeps all.
vec3 stored(vec3 color) {
    return FLOAT_OUTPUT ? color : clamp(color, 0.0, 1.0);
}

// The pixel of the final image.
vec4 output_color(vec3 exposed_light) {
    vec3 color = tonemap(exposed_light);
    return vec4(DITHER ? dither(color) : color, 1.0);
}

// Where no surface is and a colour is wanted (BACKGROUND): display light already.
vec4 background_color() {
    return vec4(BACKGROUND_RED, BACKGROUND_GREEN, BACKGROUND_BLUE, 1.0);
}

#ifdef ALL_PIXELS
#include "tonemap_inverse.glsl"
#include "bloom.glsl"

// Light is scattered over the background too: it stands for the light that looks like it.
vec3 whole_light(vec3 exposed_light, bool is_background) {
    return BACKGROUND && is_background ? tonemap_inverse(background_color().rgb) : exposed_light;
}

// The pixel of the final image, whatever is there.
vec4 whole_color(vec3 exposed_light, bool is_background) {
    if (BACKGROUND && is_background && !BLOOM) {
        return background_color();
    }
    return output_color(with_bloom(whole_light(exposed_light, is_background)));
}
#endif
