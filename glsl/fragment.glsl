// The surface that a fragment shows, and the light that leaves it whatever light sources shine. Shared by every pass that
// draws surfaces with their materials; wants pixel.glsl, brdf.glsl and Surface.

#include "material.glsl"
#include "light/lightmap.glsl"
#include "light/around.glsl"

layout(constant_id = ID_DOUBLE_SIDED) const bool DOUBLE_SIDED = false;
layout(constant_id = ID_UNLIT) const bool UNLIT = false;
layout(constant_id = ID_EMISSIVE) const bool EMISSIVE = false;
layout(constant_id = ID_LIGHTMAP) const bool LIGHTMAP = false;

layout(location = VARYING_NORMAL) in vec3 varying_normal_world;
layout(location = VARYING_TANGENT) in vec4 varying_tangent_world;

struct Fragment {
    Surface surface;
    vec3 base_color; // linear Rec.709
    float metallic;
    vec3 emission;   // cd/m^2
    float occlusion; // the share of light from all around that arrives
    float alpha;     // not yet clamped
};

// The shading normal (glTF 2.0, 3.9.3). The tangent frame is used as interpolated, as MikkTSpace requires; a
// double-sided material's back faces turn the whole frame round.
vec3 surface_normal_world(vec3 normal_sample) {
    vec3 normal_world = varying_normal_world;
    if (SLOT_NORMAL >= 0) {
        vec3 bitangent_world = cross(varying_normal_world, varying_tangent_world.xyz) * varying_tangent_world.w;
        vec3 normal_tangent = (normal_sample * 2.0 - 1.0) * vec3(vec2(material.normal_scale), 1.0);
        normal_world = varying_tangent_world.xyz * normal_tangent.x + bitangent_world * normal_tangent.y
            + varying_normal_world * normal_tangent.z;
    }
    return unit(DOUBLE_SIDED && !gl_FrontFacing ? -normal_world : normal_world);
}

// Discards the fragment where its alpha mask cuts it away, after the last sample that needs derivatives.
Fragment surface_at_fragment() {
    vec4 base_color = material_base_color();
    vec2 roughness_metallic = MATERIAL_SAMPLE(METALLIC_ROUGHNESS, vec4(1.0)).gb;
    vec3 normal_sample = MATERIAL_SAMPLE(NORMAL, vec4(0.5, 0.5, 1.0, 1.0)).rgb;
    float occlusion_sample = AMBIENT || OCCLUSION_TARGET ? MATERIAL_SAMPLE(OCCLUSION, vec4(1.0)).r : 1.0;
    vec3 emissive_sample = EMISSIVE ? MATERIAL_SAMPLE(EMISSIVE, vec4(1.0)).rgb : vec3(0.0);
    if (material_is_cut(base_color.a)) {
        discard;
    }

    Fragment fragment;
    fragment.base_color = base_color.rgb;
    fragment.alpha = base_color.a;
    fragment.metallic = material.metallic_factor * roughness_metallic.y;
    fragment.surface.position_world = position_world(gl_FragCoord.z);
    fragment.surface.lit = !UNLIT;
    fragment.surface.normal_world = surface_normal_world(normal_sample);
    fragment.surface.roughness = material.roughness_factor * roughness_metallic.x;
    fragment.surface.diffuse = diffuse_of(fragment.base_color, fragment.metallic);
    fragment.surface.f0 = f0_of(fragment.base_color, fragment.metallic);
    fragment.emission = emissive_sample * material.emissive_factor_alpha_cutoff.rgb;
    fragment.occlusion = 1.0 + material.occlusion_strength * (occlusion_sample - 1.0);
    return fragment;
}

// What leaves the surface towards the viewer besides `direct_light`, cd/m^2: its own light, light from all around, and the
// base colour of what is not lit.
vec3 indirect_light(Fragment fragment) {
    Surface surface = fragment.surface;
    vec3 light = vec3(0.0);
    if (UNLIT) {
        light = fragment.base_color;
    }
    if (EMISSIVE) {
        light += fragment.emission;
    }
    vec3 v = view_direction_world();
    float n_dot_v = clamp(dot(surface.normal_world, v), MIN_N_DOT_V, 1.0);
    if (AMBIENT) {
        // A lightmap has all diffuse light, and knows better what it is hidden from.
        light += reflected_around(surface, v, n_dot_v, fragment.occlusion, !LIGHTMAP);
    }
    if (LIGHTMAP) {
        light += lightmap_irradiance() / PI * diffuse_albedo(surface, n_dot_v);
    }
    return light;
}
