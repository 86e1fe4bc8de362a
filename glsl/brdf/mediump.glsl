// The same in half floats, as phones run what shaders declare `mediump`. Emulated: what such a shader keeps in a variable is
// rounded here, on any device alike, so that the error is that of half floats; the speed is not. Positions, and what light
// arrives and how much of it, stay `highp`, as engines have it.
//
// What half floats ask for (Lagarde and de Rousiers 2014, 3.2.1 and the notes of Filament on `mediump`):
// - |n x h|^2 in place of 1 - (n.h)^2, which is a multiple of 2^-11 near the peak and blanks out the lobes of roughness below 0.2;
// - roughness of at least 0.089, so that alpha^2 is a normal number: at 0.045 it is 4e-6, with 6 bits left;
// - V and D V held to the largest half: at grazing angles they exceed it, and infinity times a cosine of 0 is no number.

const float MIN_ROUGHNESS_MEDIUMP = 0.089;
const float MAX_HALF = 65504.0;

// To the nearest half, ties to even. Not packHalf2x16, whose direction of rounding Vulkan leaves to the device.
float as_half(float x) {
    const float least_normal = exp2(-14.0);
    const float least = exp2(-24.0);
    if (abs(x) < least_normal) {
        return roundEven(x / least) * least;
    }
    uint bits = floatBitsToUint(x);
    float rounded = uintBitsToFloat((bits + 0xfffu + ((bits >> 13) & 1u)) & ~0x1fffu);
    return abs(rounded) > MAX_HALF ? sign(x) * uintBitsToFloat(0x7f800000u) : rounded;
}

vec3 as_half(vec3 x) {
    return vec3(as_half(x.x), as_half(x.y), as_half(x.z));
}

// Of halves; their products fit into floats, so that each line has one rounding, that of a fused multiply-add.
float dot_mediump(vec3 a, vec3 b) {
    float xy = as_half(a.y * b.y + as_half(a.x * b.x));
    return as_half(a.z * b.z + xy);
}

vec3 cross_mediump(vec3 a, vec3 b) {
    return as_half(a.yzx * b.zxy - as_half(a.zxy * b.yzx));
}

float lambda_mediump(float cosine, float a2) {
    return as_half(sqrt(as_half(as_half(cosine * cosine) * as_half(1.0 - a2) + a2)));
}

Reflector reflector_mediump(Surface surface, vec3 v) {
    vec3 n = as_half(surface.normal_world);
    vec3 v_half = as_half(v);
    float roughness = as_half(max(surface.roughness, MIN_ROUGHNESS_MEDIUMP));
    float alpha = as_half(roughness * roughness);
    float a2 = as_half(alpha * alpha);
    float n_dot_v = clamp(dot_mediump(n, v_half), MIN_N_DOT_V, 1.0);
    vec3 f0 = as_half(surface.f0);
    return Reflector(n, n_dot_v, v_half, alpha, a2, lambda_mediump(n_dot_v, a2), f0, as_half(1.0 - f0));
}

Reflected brdf_mediump(Reflector r, vec3 l_highp) {
    vec3 l = as_half(l_highp);
    float n_dot_l = clamp(dot_mediump(r.n, l), 0.0, 1.0);
    vec3 half_way = as_half(r.v + l);
    // Light that shines straight at the viewer has no direction half way.
    const float least = exp2(-14.0);
    vec3 h = as_half(half_way * as_half(inversesqrt(max(dot_mediump(half_way, half_way), least))));

    float n_dot_h = clamp(dot_mediump(r.n, h), 0.0, 1.0);
    vec3 n_cross_h = cross_mediump(r.n, h);
    float a = as_half(n_dot_h * r.alpha);
    float f = max(as_half(a * a + dot_mediump(n_cross_h, n_cross_h)), r.a2);
    float d = n_dot_h > 0.0 ? as_half(as_half(as_half(r.a2 / f) / f) / PI) : 0.0;

    float lambda_l = lambda_mediump(n_dot_l, r.a2);
    float visibility = as_half(0.5 / as_half(n_dot_l * r.lambda_v + as_half(r.n_dot_v * lambda_l)));
    float specular = min(as_half(d * min(visibility, MAX_HALF)), MAX_HALF);

    float m = as_half(1.0 - clamp(dot_mediump(r.v, h), 0.0, 1.0));
    float m2 = as_half(m * m);
    float m5 = as_half(as_half(m2 * m2) * m);
    float diffuse = as_half(as_half(1.0 - DIELECTRIC_F0) * as_half(1.0 - m5));
    return Reflected(vec3(diffuse), as_half(specular * as_half(r.f0 + as_half(r.f_rise * m5))));
}
