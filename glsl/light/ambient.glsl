// Light from all around, reflected: what ambient light and environments share. Wants light/diffuse.glsl.

// The albedo of the specular lobe is f0 a + b; columns of the table are sqrt(n.v), rows roughness, from the first texel's
// centre to the last one's (src/environment/split_sum.rs).
layout(set = SET_FRAME, binding = BINDING_SPLIT_SUM) uniform sampler2D split_sum;

vec2 specular_albedo(float n_dot_v, float roughness) {
    vec2 size = vec2(textureSize(split_sum, 0));
    vec2 place = vec2(sqrt(n_dot_v), roughness) * (size - 1.0) + 0.5;
    return textureLod(split_sum, place / size, 0.0).xy;
}

// cd/m^2 towards the viewer. diffuse_nt: irradiance over pi; specular_nt: radiance around the mirror direction, blurred for
// the roughness. Exact where light is the same from everywhere, else Karis' split sum ("Real Shading in Unreal Engine 4",
// 2013). Occlusion, as glTF 2.0 section 3.9.3 has it, dims this light only.
vec3 light_around(Surface surface, float n_dot_v, vec3 diffuse_nt, vec3 specular_nt, float occlusion) {
    vec2 albedo = specular_albedo(n_dot_v, surface.roughness);
    vec3 diffuse = diffuse_nt * diffuse_albedo(surface, n_dot_v);
    return occlusion * (diffuse + specular_nt * (surface.f0 * albedo.x + albedo.y));
}
