#version 450
// All lights on one pixel or sample, or (ONE_LIGHT) only the one whose volume is drawn. FOLD: tonemaps and writes the output; else
// fixed-function blending adds to the light target, or the shader to the light of the G-buffer (LIGHT_READ).
#extension GL_GOOGLE_include_directive : require
#define SUBPASS_LIGHTING
#include "common.glsl"
#include "frame.glsl"
#include "pixel.glsl"
#include "gbuffer.glsl"
#include "brdf.glsl"
#include "light/direct.glsl"
#include "light/around.glsl"
#include "fog.glsl"
#define ALL_PIXELS
#include "tonemap.glsl"

layout(constant_id = ID_FOLD) const bool FOLD = false;
layout(constant_id = ID_ONE_LIGHT) const bool ONE_LIGHT = false;

#ifdef MULTISAMPLED
// The stencil says which pixels are lit by sample: not after they were.
layout(early_fragment_tests) in;
#endif

layout(location = VARYING_LIGHT) flat in uint varying_light;

layout(location = TARGET_LIGHT) out vec4 target_light;
layout(location = TARGET_SPECULAR_LIGHT) out vec4 target_specular_light;
layout(location = TARGET_OUTPUT) out vec4 target_output;

Reflected light_of(Surface surface) {
    vec3 v = view_direction_world();
    if (!ONE_LIGHT) {
        return direct_light(surface, v);
    }
    bool is_everywhere = HAS_DIRECTIONAL && varying_light < frame.light_counts.x;
    if (is_everywhere || is_lit_from(varying_light, surface, surface.position_world)) {
        return light_reflected(varying_light, surface, reflector(surface, v), surface.position_world);
    }
    return Reflected(vec3(0.0), vec3(0.0));
}

void main() {
#ifdef MULTISAMPLED
    input_sample = PER_SAMPLE ? gl_SampleID : 0;
#endif
    Surface surface = gbuffer_read();
    Reflected light = Reflected(vec3(0.0), vec3(0.0));
    vec3 around = vec3(0.0); // complete
    if (surface.lit) {
        light = light_of(surface);
        if (AMBIENT) {
            vec3 v = view_direction_world();
            float n_dot_v = clamp(dot(surface.normal_world, v), MIN_N_DOT_V, 1.0);
            around = reflected_around(surface, v, n_dot_v, gbuffer_read_occlusion(), true);
        }
    } else {
        // What nothing was written to may be no number, and 0 times that is none.
        surface.diffuse = vec3(0.0);
    }
    // Pixels that are not lit add 0. `discard` would save tilers nothing, since blending stays on the tile, but it
    // makes a fragment's coverage depend on its shader, which costs Mali its early kills and PowerVR its deferral.
    if (!FOLD) {
        float scale = frame.exposure * frame.light_scale;
        if (LIGHT_READ) {
            gbuffer_add_light((complete(light, surface) + around) * scale);
            return;
        }
        target_light = vec4((SPLIT_LIGHT ? light.diffuse / PI : complete(light, surface) + around) * scale, 0.0);
        if (SPLIT_LIGHT) {
            target_specular_light = vec4((light.specular + around) * scale, 0.0);
        }
        return;
    }
    vec3 exposed_light = (complete(light, surface) + around) * frame.exposure;
    bool is_surface = surface.lit;
    if (LIGHT_READ) {
        vec4 stored = gbuffer_read_light(FOG || BACKGROUND);
        is_surface = stored.a > 0.0;
        exposed_light += stored.rgb / frame.light_scale;
    }
    if (FOG && is_surface) {
        exposed_light = fogged(exposed_light, surface.position_world);
    }
    // There is no one else to write the background.
    target_output = whole_color(exposed_light, !is_surface);
}
