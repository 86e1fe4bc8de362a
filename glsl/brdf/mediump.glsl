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

// What `mediump` holds of a number: the nearest half, ties to even. Not packHalf2x16, whose direction of rounding Vulkan leaves to the device.
float held(float x) {
    const float least_normal = exp2(-14.0);
    const float least = exp2(-24.0);
    if (abs(x) < least_normal) {
        return roundEven(x / least) * least;
    }
    uint bits = floatBitsToUint(x);
    float rounded = uintBitsToFloat((bits + 0xfffu + ((bits >> 13) & 1u)) & ~0x1fffu);
    return abs(rounded) > MAX_HALF ? sign(x) * uintBitsToFloat(0x7f800000u) : rounded;
}

vec3 held(vec3 x) {
    return vec3(held(x.x), held(x.y), held(x.z));
}

// Of halves; their products fit into floats, so that each line has one rounding, that of a fused multiply-add.
float dot_mediump(vec3 a, vec3 b) {
    float xy = held(a.y * b.y + held(a.x * b.x));
    return held(a.z * b.z + xy);
}

vec3 cross_mediump(vec3 a, vec3 b) {
    return held(a.yzx * b.zxy - held(a.zxy * b.yzx));
}

float lambda_mediump(float cosine, float a2) {
    return held(sqrt(held(held(cosine * cosine) * held(1.0 - a2) + a2)));
}

Reflector reflector_mediump(Surface surface, vec3 v) {
    vec3 n = held(surface.normal_world);
    vec3 v_half = held(v);
    float roughness = held(max(surface.roughness, MIN_ROUGHNESS_MEDIUMP));
    float alpha = held(roughness * roughness);
    float a2 = held(alpha * alpha);
    float n_dot_v = clamp(dot_mediump(n, v_half), MIN_N_DOT_V, 1.0);
    vec3 f0 = held(surface.f0);
    return Reflector(n, n_dot_v, v_half, alpha, a2, lambda_mediump(n_dot_v, a2), f0, held(1.0 - f0));
}

Reflected brdf_mediump(Reflector r, vec3 l_highp) {
    vec3 l = held(l_highp);
    float n_dot_l = clamp(dot_mediump(r.n, l), 0.0, 1.0);
    vec3 half_way = held(r.v + l);
    // Light that shines straight at the viewer has no direction half way.
    const float least = exp2(-14.0);
    vec3 h = held(half_way * held(inversesqrt(max(dot_mediump(half_way, half_way), least))));

    float n_dot_h = clamp(dot_mediump(r.n, h), 0.0, 1.0);
    vec3 n_cross_h = cross_mediump(r.n, h);
    float a = held(n_dot_h * r.alpha);
    float f = max(held(a * a + dot_mediump(n_cross_h, n_cross_h)), r.a2);
    float d = n_dot_h > 0.0 ? held(held(held(r.a2 / f) / f) / PI) : 0.0;

    float lambda_l = lambda_mediump(n_dot_l, r.a2);
    float visibility = held(0.5 / held(n_dot_l * r.lambda_v + held(r.n_dot_v * lambda_l)));
    float specular = min(held(d * min(visibility, MAX_HALF)), MAX_HALF);

    float m = held(1.0 - clamp(dot_mediump(r.v, h), 0.0, 1.0));
    float m2 = held(m * m);
    float m5 = held(held(m2 * m2) * m);
    float diffuse = held(held(1.0 - DIELECTRIC_F0) * held(1.0 - m5));
    return Reflected(vec3(diffuse), held(specular * held(r.f0 + held(r.f_rise * m5))));
}
