// From display light back to the exposed light that the curve made it of (src/reference/tonemap_inverse.rs): exact where the curve
// and the display lose nothing, else the least light that looks like it. Wants the constant TONEMAP.

// The curves reach 1 at infinity, which the last of 255 steps shows from its lower half on.
const float DISPLAY_MOST = 0.99555; // sRGB 254.5 / 255

// Khronos PBR Neutral Tone Mapper, specification 2024, its three steps undone from the last.
vec3 inverse_neutral(vec3 color) {
    const float fresnel = 0.04;
    const float start = 0.8 - fresnel;
    const float desaturation = 0.15;
    float compressed = max(color.r, max(color.g, color.b));
    if (compressed > start) {
        const float room = 1.0 - start;
        float peak = room * room / (1.0 - compressed) - room + start;
        float white = 1.0 - 1.0 / (desaturation * (peak - compressed) + 1.0);
        // mix(color * compressed / peak, compressed, white), undone
        color = max((color - compressed * white) / (1.0 - white), 0.0) * (peak / compressed);
    }
    // The least channel x became x^2 / (4 fresnel) below 2 fresnel, and x - fresnel above; all others lost as much.
    float low = min(color.r, min(color.g, color.b));
    float x = low < fresnel ? 2.0 * sqrt(fresnel * max(low, 0.0)) : low + fresnel;
    return color + (x - low);
}

// Hill's fit: a rational function of each channel between two matrices.
vec3 inverse_aces(vec3 color) {
    const mat3 fit_from_rec709 = mat3( // the inverse of rec709_from_fit in tonemap.glsl
        0.643038249, 0.311186752, 0.045775457,
        0.059268690, 0.931436487, 0.009294916,
        0.005961901, 0.063929016, 0.930118384);
    const mat3 rec709_from_fit = mat3( // the inverse of fit_from_rec709 there
        1.764740972, -0.675777678, -0.088963294,
        -0.147027852, 1.160251512, -0.013223660,
        -0.036336830, -0.162436437, 1.198773267);
    vec3 y = clamp(color * fit_from_rec709, 0.0, 0.98);
    // y = (x^2 + 0.0245786 x - 0.000090537) / (0.983729 x^2 + 0.432951 x + 0.238081), solved for x >= 0
    vec3 a = 1.0 - 0.983729 * y;
    vec3 b = 0.0245786 - 0.4329510 * y;
    vec3 c = -0.000090537 - 0.238081 * y;
    vec3 x = (sqrt(max(b * b - 4.0 * a * c, 0.0)) - b) / (2.0 * a);
    return max(x * rec709_from_fit, 0.0);
}

vec3 tonemap_inverse(vec3 color) {
    if (TONEMAP == TONEMAP_LINEAR) {
        return max(color, 0.0);
    }
    color = clamp(color, 0.0, DISPLAY_MOST);
    if (TONEMAP == TONEMAP_NEUTRAL) {
        return inverse_neutral(color);
    }
    if (TONEMAP == TONEMAP_ACES) {
        return inverse_aces(color);
    }
    return color / (1.0 - color);
}
