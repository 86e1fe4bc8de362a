#version 450
// Adds a particle's light to what is behind it, less of it the nearer that is.
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "frame.glsl"
#include "pixel.glsl"
#include "fog.glsl"
#include "material.glsl"

layout(location = VARYING_PARTICLE) flat in vec4 varying_particle;

layout(constant_id = ID_FORM) const uint FORM = FORM_METALLIC;
const bool SPLIT_LIGHT = FORM == FORM_RASA128;
#include "gbuffer/light_target.glsl"

#include "behind.glsl"

// The function `Contrast` of Lorach 2007, "Soft Particles" (NVIDIA), with power 2.
float contrast(float share) {
    share = clamp(share, 0.0, 1.0);
    float to_end = min(share, 1.0 - share);
    float raised = 2.0 * to_end * to_end;
    return share > 0.5 ? 1.0 - raised : raised;
}

// Over the samples that it is in front of.
float fade(float distance) {
    float inverse_soft = varying_particle.a;
    float from_near = contrast((distance - distance_of(1.0)) * inverse_soft);
    if (!HAS_BEHIND) {
        return from_near;
    }
    float sum = 0.0;
    float before = 0.0;
    for (int i = 0; i < SAMPLE_COUNT; ++i) {
        float behind = depth_behind(i);
        if (behind < gl_FragCoord.z) {
            sum += contrast((distance_of(behind) - distance) * inverse_soft);
            before += 1.0;
        }
    }
    return from_near * sum / max(before, 1.0);
}

void main() {
    vec3 color = MATERIAL_SAMPLE(EMISSIVE, vec4(1.0)).rgb * material.emissive_factor_alpha_cutoff.rgb * varying_particle.rgb;
    float share = fade(distance_of(gl_FragCoord.z));
    if (FOG) {
        share *= fog_transmittance(ray_origin_world(), position_world(gl_FragCoord.z));
    }
    light_over(vec4(color * (share * frame.exposure * frame.light_scale), 0.0));
}
