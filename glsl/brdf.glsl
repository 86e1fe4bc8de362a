// The metallic-roughness BRDF of glTF 2.0, appendix B. n, v, l, h: surface normal, directions towards the viewer
// and the light, and their half vector; all unit length, in one space. alpha = roughness * roughness.

// How it is evaluated: as written there, by fits without square roots, or in half floats.
layout(constant_id = ID_BRDF) const int BRDF = BRDF_EXACT;

// Perceptual roughness below this is raised to it. D peaks at 1 / (pi alpha^2): at 0 that is infinite, here
// 7.8e4, so that D V of a unit light stays within half floats (65504), and the float rounding of h (1e-7) stays
// far below the lobe's width (alpha = 2e-3).
const float MIN_ROUGHNESS = 0.045;

// At grazing angles interpolated and quantised normals may face away from the viewer.
const float MIN_N_DOT_V = 1e-4;

// What is the same for all lights on a surface seen from `v`.
struct Reflector {
    vec3 n;
    float n_dot_v;
    vec3 v;
    float alpha;
    float a2;       // alpha^2
    float lambda_v; // the viewer's square root of v_smith_correlated
    vec3 f0;        // Fresnel reflectance at normal incidence, dielectric and metal mixed
    vec3 f_rise;    // from there to grazing incidence
};

// What a surface reflects. Diffuse light is still to be multiplied by albedo / pi, once for all lights.
struct Reflected {
    vec3 diffuse;
    vec3 specular;
};

vec3 complete(Reflected light, Surface surface) {
    return light.diffuse * (surface.diffuse / PI) + light.specular;
}

#include "brdf/mediump.glsl"

Reflector reflector(Surface surface, vec3 v) {
    if (BRDF == BRDF_MEDIUMP) {
        return reflector_mediump(surface, v);
    }
    float roughness = max(surface.roughness, MIN_ROUGHNESS);
    float alpha = roughness * roughness;
    float a2 = alpha * alpha;
    float n_dot_v = clamp(dot(surface.normal_world, v), MIN_N_DOT_V, 1.0);
    return Reflector(surface.normal_world, n_dot_v, v, alpha, a2,
        sqrt(n_dot_v * n_dot_v * (1.0 - a2) + a2), surface.f0, 1.0 - surface.f0);
}

// GGX (Trowbridge and Reitz 1975; Walter et al. 2007, equation 33) for h = half_way / |half_way|, which is never normalised:
// both terms of the denominator scale with its square. 1 - (n.h)^2 is taken as |n x h|^2, since the difference cancels where
// the lobe of a smooth surface is steepest. No microfacet faces below the surface. The denominator is at least a2 for any
// unit h; the bound stands in for half_way = 0, when the light shines straight at the viewer.
float d_ggx(vec3 n, vec3 half_way, float half_way_squared, float a2) {
    const float least = 1e-30;
    float n_dot_h = dot(n, half_way);
    vec3 n_cross_h = cross(n, half_way);
    float f = max(n_dot_h * n_dot_h * a2 + dot(n_cross_h, n_cross_h), a2 * half_way_squared + least);
    float ratio = half_way_squared / f;
    return n_dot_h > 0.0 ? a2 / PI * (ratio * ratio) : 0.0;
}

// G / (4 (n.l) (n.v)), height-correlated Smith (Heitz 2014, equation 99). With n.v >= MIN_N_DOT_V and
// alpha >= MIN_ROUGHNESS^2 the denominator is at least 2e-7, also where n.l = 0.
float v_smith_correlated(float n_dot_l, Reflector r) {
    float lambda_l = sqrt(n_dot_l * n_dot_l * (1.0 - r.a2) + r.a2);
    return 0.5 / (n_dot_l * r.lambda_v + r.n_dot_v * lambda_l);
}

// The same without square roots: exact at alpha = 0 and 1, the denominator linear in alpha between (Hammon, "PBR Diffuse
// Lighting for GGX+Smith Microsurfaces", 2017, "Smith's shadowing-masking").
float v_smith_fitted(float n_dot_l, Reflector r) {
    return 0.5 / mix(2.0 * n_dot_l * r.n_dot_v, n_dot_l + r.n_dot_v, r.alpha);
}

// Towards r.v of light from l, a unit vector with n.l = n_dot_l, for an irradiance of 1.
// glTF 2.0, B.2 mixes the dielectric's (1 - F_d) base / pi + F_d D V and the metal's F_m D V by metallicness. Schlick's F is
// linear in f0, so both shares of D V become one, and 1 - F_d = (1 - f0) (1 - m^5).
Reflected brdf(Reflector r, vec3 l, float n_dot_l) {
    if (BRDF == BRDF_MEDIUMP) {
        return brdf_mediump(r, l);
    }
    vec3 half_way = r.v + l;
    float half_way_squared = dot(half_way, half_way);
    // Schlick 1994, equation 15, with f90 = 1; |v + l| = 2 (v.h).
    float m = max(1.0 - 0.5 * sqrt(half_way_squared), 0.0);
    float m2 = m * m;
    float m5 = m2 * m2 * m;
    float visibility = BRDF == BRDF_FITTED ? v_smith_fitted(n_dot_l, r) : v_smith_correlated(n_dot_l, r);
    float specular = d_ggx(r.n, half_way, half_way_squared, r.a2) * visibility;
    return Reflected(vec3((1.0 - DIELECTRIC_F0) * (1.0 - m5)), specular * (r.f0 + r.f_rise * m5));
}
