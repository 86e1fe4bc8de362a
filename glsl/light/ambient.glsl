// Light from all around, reflected: what ambient light and environments share. Wants light/diffuse.glsl.

// The albedo of the specular lobe is f0 a + b; columns of the table are sqrt(n.v), rows roughness, from the first texel's
// centre to the last one's (src/environment/split_sum.rs).
layout(set = SET_FRAME, binding = BINDING_SPLIT_SUM) uniform sampler2D split_sum;

// A fit (Karis, "Physically Based Shading on Mobile", 2014): no table, no look-up.
vec2 specular_albedo_fitted(float n_dot_v, float roughness) {
    vec4 r = roughness * vec4(-1.0, -0.0275, -0.572, 0.022) + vec4(1.0, 0.0425, 1.04, -0.04);
    float edge = min(r.x * r.x, exp2(-9.28 * n_dot_v)) * r.x + r.y;
    return vec2(-1.04, 1.04) * edge + r.zw;
}

vec2 specular_albedo(float n_dot_v, float roughness) {
    if (BRDF == BRDF_FITTED) {
        return specular_albedo_fitted(n_dot_v, roughness);
    }
    vec2 size = vec2(textureSize(split_sum, 0));
    vec2 place = vec2(sqrt(n_dot_v), roughness) * (size - 1.0) + 0.5;
    return textureLod(split_sum, place / size, 0.0).xy;
}

// cd/m^2 towards the viewer. diffuse_nt: irradiance over pi; specular_nt: radiance around the mirror direction, blurred for
// the roughness. Exact where light is the same from everywhere, else Karis' split sum ("Real Shading in Unreal Engine 4",
// 2013). Occlusion, as glTF 2.0 section 3.9.3 has it, dims this light only.
vec3 light_around(Surface surface, float n_dot_v, vec3 diffuse_nt, vec3 specular_nt, float occlusion) {
    vec2 albedo = specular_albedo(n_dot_v, surface.roughness);
    vec3 reflectance = surface.f0 * albedo.x + albedo.y;
    if (BRDF == BRDF_MEDIUMP) {
        reflectance = held(held(surface.f0) * held(albedo.x) + held(albedo.y));
    }
    vec3 diffuse = diffuse_nt * diffuse_albedo(surface, n_dot_v);
    return occlusion * (diffuse + specular_nt * reflectance);
}
