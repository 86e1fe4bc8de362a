#version 450
// Writes a material's surface to the G-buffer, and the light that needs no other pixel (emissive, ambient, unlit)
// to the light target where the plan has one (LIGHT_TARGET).
#extension GL_GOOGLE_include_directive : require
#define SUBPASS_GEOMETRY
#include "common.glsl"
#include "frame.glsl"
#include "pixel.glsl"
#include "gbuffer.glsl"
#include "material.glsl"

layout(constant_id = ID_DOUBLE_SIDED) const bool DOUBLE_SIDED = false;
layout(constant_id = ID_UNLIT) const bool UNLIT = false;

layout(location = VARYING_NORMAL) in vec3 varying_normal_world;

#ifdef TEXTURED
layout(location = VARYING_TANGENT) in vec4 varying_tangent_world;
#endif

#ifdef LIGHT_TARGET
#include "brdf.glsl"
#include "light/ambient.glsl"

layout(constant_id = ID_EMISSIVE) const bool EMISSIVE = false;
layout(constant_id = ID_AMBIENT) const bool AMBIENT = false;

layout(location = TARGET_LIGHT) out vec4 target_light;
#endif

// The shading normal (glTF 2.0, 3.9.3). The tangent frame is used as interpolated, as MikkTSpace requires; a
// double-sided material's back faces turn the whole frame round.
vec3 surface_normal_world(vec3 normal_sample) {
    vec3 normal_world = varying_normal_world;
#ifdef TEXTURED
    if (SLOT_NORMAL >= 0) {
        vec3 bitangent_world = cross(varying_normal_world, varying_tangent_world.xyz) * varying_tangent_world.w;
        vec3 normal_tangent = (normal_sample * 2.0 - 1.0) * vec3(vec2(material.normal_scale), 1.0);
        normal_world = varying_tangent_world.xyz * normal_tangent.x + bitangent_world * normal_tangent.y
            + varying_normal_world * normal_tangent.z;
    }
#endif
    return unit(DOUBLE_SIDED && !gl_FrontFacing ? -normal_world : normal_world);
}

void main() {
    vec4 base_color = material_base_color();
    vec2 roughness_metallic = MATERIAL_SAMPLE(METALLIC_ROUGHNESS, vec4(1.0)).gb;
    vec3 normal_sample = MATERIAL_SAMPLE(NORMAL, vec4(0.5, 0.5, 1.0, 1.0)).rgb;
#ifdef LIGHT_TARGET
    float occlusion_sample = AMBIENT ? MATERIAL_SAMPLE(OCCLUSION, vec4(1.0)).r : 1.0;
    vec3 emissive_sample = EMISSIVE ? MATERIAL_SAMPLE(EMISSIVE, vec4(1.0)).rgb : vec3(0.0);
#endif
    if (material_is_cut(base_color.a)) {
        discard;
    }

    Surface surface;
    surface.depth = gl_FragCoord.z;
    surface.lit = !UNLIT;
    surface.normal_world = surface_normal_world(normal_sample);
    surface.roughness = material.roughness_factor * roughness_metallic.x;
    surface.base_color = base_color.rgb;
    surface.metallic = material.metallic_factor * roughness_metallic.y;
    gbuffer_write(surface);

#ifdef LIGHT_TARGET
    vec3 light = vec3(0.0);
    if (UNLIT) {
        light = surface.base_color;
    }
    if (EMISSIVE) {
        light += emissive_sample * material.emissive_factor_alpha_cutoff.rgb;
    }
    if (AMBIENT) {
        float n_dot_v = clamp(dot(surface.normal_world, view_direction_world()), MIN_N_DOT_V, 1.0);
        float occlusion = 1.0 + material.occlusion_strength * (occlusion_sample - 1.0);
        light += light_ambient(surface, n_dot_v, frame.ambient_nt.rgb, occlusion);
    }
    target_light = vec4(light * (frame.exposure * frame.light_scale), 1.0);
#endif
}
