// What a surface reflects of diffuse light from all around.

// The part of light that the coat of a dielectric lets through to its diffuse base, but for 1 - f0: one less the mean of
// (1 - v.h)^5 over light from all around, as a cubic (src/environment/split_sum.rs).
float transmission(float n_dot_v) {
    return 0.97191 + n_dot_v * (0.07756 + n_dot_v * (-0.07515 + n_dot_v * 0.02567));
}

// Times irradiance over pi: cd/m^2 towards the viewer.
vec3 diffuse_albedo(Surface surface, float n_dot_v) {
    vec3 albedo = surface.diffuse * ((1.0 - DIELECTRIC_F0) * transmission(n_dot_v));
    return BRDF == BRDF_MEDIUMP ? held(albedo) : albedo;
}
