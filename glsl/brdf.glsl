// The metallic-roughness BRDF of glTF 2.0, appendix B. n, v, l, h: surface normal, directions towards the viewer
// and the light, and their half vector; all unit length, in one space. alpha = roughness * roughness.

// Perceptual roughness below this is raised to it. D peaks at 1 / (pi alpha^2): at 0 that is infinite, here
// 7.8e4, so that D V of a unit light stays within half floats (65504), and the float rounding of h (1e-7) stays
// far below the lobe's width (alpha = 2e-3).
const float MIN_ROUGHNESS = 0.045;

// Reflectance at normal incidence of a dielectric with index of refraction 1.5 (glTF 2.0, B.2.1).
const float DIELECTRIC_F0 = 0.04;

// At grazing angles interpolated and quantised normals may face away from the viewer.
const float MIN_N_DOT_V = 1e-4;

// GGX (Trowbridge and Reitz 1975; Walter et al. 2007, equation 33). 1 - (n.h)^2 is taken as |n x h|^2, since the
// difference cancels where the lobe of a smooth surface is steepest. No microfacet faces below the surface. f is
// at least a2 for any unit h; the bound stands in for h = 0, when the light shines straight at the viewer.
float d_ggx(float n_dot_h, vec3 n_cross_h, float alpha) {
    float a2 = alpha * alpha;
    float f = max(n_dot_h * n_dot_h * a2 + dot(n_cross_h, n_cross_h), a2);
    return float(n_dot_h > 0.0) * a2 / (PI * f * f);
}

// G / (4 (n.l) (n.v)), height-correlated Smith (Heitz 2014, equation 99). With n.v >= MIN_N_DOT_V and
// alpha >= MIN_ROUGHNESS^2 the denominator is at least 2e-7, also where n.l = 0.
float v_smith_correlated(float n_dot_l, float n_dot_v, float alpha) {
    float a2 = alpha * alpha;
    float lambda_v = n_dot_l * sqrt(n_dot_v * n_dot_v * (1.0 - a2) + a2);
    float lambda_l = n_dot_v * sqrt(n_dot_l * n_dot_l * (1.0 - a2) + a2);
    return 0.5 / (lambda_v + lambda_l);
}

// Schlick 1994, equation 15, with f90 = 1.
vec3 f_schlick(vec3 f0, float v_dot_h) {
    float m = 1.0 - v_dot_h;
    float m2 = m * m;
    return f0 + (1.0 - f0) * (m2 * m2 * m);
}

// Per steradian; the caller multiplies by n.l and the light. B.2: dielectric and metal mixed by metallicness.
vec3 brdf(Surface surface, vec3 n, vec3 v, vec3 l) {
    float roughness = max(surface.roughness, MIN_ROUGHNESS);
    float alpha = roughness * roughness;
    vec3 h = unit(v + l);
    float n_dot_l = clamp(dot(n, l), 0.0, 1.0);
    float n_dot_v = clamp(dot(n, v), MIN_N_DOT_V, 1.0);
    float n_dot_h = clamp(dot(n, h), 0.0, 1.0);
    float v_dot_h = clamp(dot(v, h), 0.0, 1.0);

    float specular = d_ggx(n_dot_h, cross(n, h), alpha) * v_smith_correlated(n_dot_l, n_dot_v, alpha);
    vec3 dielectric = mix(surface.base_color / PI, vec3(specular), f_schlick(vec3(DIELECTRIC_F0), v_dot_h));
    vec3 metal = specular * f_schlick(surface.base_color, v_dot_h);
    return mix(dielectric, metal, surface.metallic);
}
