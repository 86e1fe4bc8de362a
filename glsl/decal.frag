#version 450
// Paints a decal over the surface that is in its box: reads the G-buffer's pixel, changes some of its channels and writes it back.
// Each channel is one pipeline's or not (DECAL_*). DECAL_BLENDED: base colour alone, mixed by fixed-function blending.
#extension GL_GOOGLE_include_directive : require
#define SUBPASS_DECALS
#include "common.glsl"
#include "frame.glsl"
#include "pixel.glsl"
#include "gbuffer.glsl"
#include "decal.glsl"

layout(constant_id = ID_DECAL_BLENDED) const bool DECAL_BLENDED = false;

// Of the box's picture, with what it changes by from a pixel to the next.
struct Texcoord {
    vec2 at;
    vec2 right;
    vec2 down;
};
Texcoord decal_texcoord;

#define MATERIAL_SET SET_DECAL_MATERIAL
#define MATERIAL_TEXTURE(SAMPLER, KIND) \
    textureGrad(SAMPLER, decal_uv(KIND, decal_texcoord.at, 1.0), decal_uv(KIND, decal_texcoord.right, 0.0), \
        decal_uv(KIND, decal_texcoord.down, 0.0))
vec2 decal_uv(int kind, vec2 texcoord, float moved);
#include "material.glsl"

layout(location = VARYING_DECAL) flat in uint varying_decal;

// A texture coordinate, or (moved 0) a difference of two.
vec2 decal_uv(int kind, vec2 texcoord, float moved) {
    if ((TRANSFORM_BITS >> kind & 1u) != 0u) {
        vec3 h = vec3(texcoord, moved);
        return vec2(dot(material.uv_rows[kind][0].xyz, h), dot(material.uv_rows[kind][1].xyz, h));
    }
    return texcoord;
}

// By how much the surface's place moves if the pixel does, the surface taken for the plane across its normal: neighbouring pixels
// may show other surfaces, and say nothing of this one. Grazing, it is held to 20 times what it is face to face.
vec3 place_moved(Surface surface, vec3 view_plane_moved) {
    const float least_cosine = 0.05;
    vec3 ray = ray_world();
    float distance = dot(surface.position_world - frame.camera_position_world.xyz, frame.forward_world.xyz);
    vec3 moved = view_plane_moved * mix(1.0, distance, frame.camera_position_world.w);
    float slope = min(dot(ray, surface.normal_world), -least_cosine * length(ray));
    return moved - ray * (dot(moved, surface.normal_world) / slope);
}

vec3 in_box(Decal decal, vec4 h) {
    return vec3(
        dot(decal.decal_from_world_rows[0], h), dot(decal.decal_from_world_rows[1], h),
        dot(decal.decal_from_world_rows[2], h));
}

vec2 texcoord_moved(Decal decal, vec3 moved_world) {
    return in_box(decal, vec4(moved_world, 0.0)).xy * vec2(1.0, -1.0);
}

float smooth_step(float t) {
    return t * t * (3.0 - 2.0 * t);
}

// The product of the falloffs within the faces and of that by angle; 0 outside the box.
float weight_of(Decal decal, vec3 place, vec3 normal_world) {
    vec3 t = clamp((0.5 - abs(place)) * decal.inverse_falloff, 0.0, 1.0);
    float cosine = dot(normal_world, decal_axis_world(decal, 2));
    float facing = clamp(cosine * decal.facing.x + decal.facing.y, 0.0, 1.0);
    return smooth_step(t.x) * smooth_step(t.y) * smooth_step(t.z) * smooth_step(facing);
}

// The sampled normal in the frame of the surface's own, which keeps what bumps that has (Barre-Brisebois and Hill, "Blending in
// Detail", 2012), mixed with it by weight and made unit length.
vec3 painted_normal_world(Decal decal, vec3 normal_world, vec3 normal_sample, float weight) {
    vec3 right = decal_axis_world(decal, 0);
    vec3 tangent = unit(right - normal_world * dot(right, normal_world));
    vec3 bitangent = cross(normal_world, tangent) * decal.handedness;
    vec3 sampled = unit((normal_sample * 2.0 - 1.0) * vec3(vec2(material.normal_scale), 1.0));
    vec3 mixed = mix(vec3(0.0, 0.0, 1.0), sampled, weight);
    return unit(tangent * mixed.x + bitangent * mixed.y + normal_world * mixed.z);
}

void main() {
#ifdef MULTISAMPLED
    input_sample = PER_SAMPLE ? gl_SampleID : 0;
#endif
    Surface surface = gbuffer_read();
    Decal decal = decals[varying_decal];
    vec3 place = in_box(decal, vec4(surface.position_world, 1.0));
    float weight = surface.lit ? weight_of(decal, place, surface.normal_world) : 0.0;

    vec2 pixel = 2.0 * frame.inverse_size;
    decal_texcoord = Texcoord(
        vec2(0.5 + place.x, 0.5 - place.y),
        texcoord_moved(decal, place_moved(surface, frame.right_world.xyz * pixel.x)),
        texcoord_moved(decal, place_moved(surface, frame.down_world.xyz * pixel.y)));
    vec4 color = material.base_color_factor * MATERIAL_SAMPLE(BASE_COLOR, vec4(1.0));
    weight *= color.a;
    if (!(weight > 0.0)) {
        discard;
    }

    vec4 weights = decal.opacity * weight;
    if (DECAL_BLENDED) {
        target_base_metallic = vec4(encode_color(color.rgb), weights.x);
        return;
    }
    Paint paint = Paint(vec3(0.0), 0.0, 0.0, surface.normal_world);
    vec2 roughness_metallic = MATERIAL_SAMPLE(METALLIC_ROUGHNESS, vec4(1.0)).gb;
    if (DECAL_BASE_COLOR || DECAL_METALLIC) {
        vec4 base_metallic = gbuffer_read_base_metallic();
        paint.base_color = mix(base_metallic.rgb, color.rgb, DECAL_BASE_COLOR ? weights.x : 0.0);
        float metallic = material.metallic_factor * roughness_metallic.y;
        paint.metallic = mix(base_metallic.a, metallic, DECAL_METALLIC ? weights.w : 0.0);
    }
    if (DECAL_ROUGHNESS) {
        paint.roughness = mix(surface.roughness, material.roughness_factor * roughness_metallic.x, weights.z);
    }
    if (DECAL_NORMAL) {
        vec3 normal_sample = MATERIAL_SAMPLE(NORMAL, vec4(0.5, 0.5, 1.0, 1.0)).rgb;
        paint.normal_world = painted_normal_world(decal, surface.normal_world, normal_sample, weights.y);
    }
    gbuffer_paint(paint);
}
