// Light that arrives from every direction alike.

// The share of uniform light that a GGX lobe reflects: Karis 2014, "Physically Based Shading on Mobile" (the fit
// that Unreal Engine 4 uses in place of a lookup table).
vec3 env_brdf(vec3 f0, float roughness, float n_dot_v) {
    const vec4 c0 = vec4(-1.0, -0.0275, -0.572, 0.022);
    const vec4 c1 = vec4(1.0, 0.0425, 1.04, -0.04);
    vec4 r = roughness * c0 + c1;
    float a004 = min(r.x * r.x, exp2(-9.28 * n_dot_v)) * r.x + r.y;
    vec2 scale_bias = vec2(-1.04, 1.04) * a004 + r.zw;
    return f0 * scale_bias.x + scale_bias.y;
}

// cd/m^2 towards the viewer. Occlusion, as glTF 2.0 section 3.9.3 has it, dims this light only.
vec3 light_ambient(Surface surface, float n_dot_v, vec3 ambient_nt, float occlusion) {
    vec3 f0 = mix(vec3(DIELECTRIC_F0), surface.base_color, surface.metallic);
    vec3 diffuse = surface.base_color * (1.0 - surface.metallic);
    return ambient_nt * occlusion * (diffuse + env_brdf(f0, surface.roughness, n_dot_v));
}
