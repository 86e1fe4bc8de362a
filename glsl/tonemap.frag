#version 450
// From the light target, or what the G-buffer holds of light (LIGHT_READ), to the output. What fog and separate diffuse light
// need is read from the G-buffer.
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "frame.glsl"
#include "pixel.glsl"
#include "gbuffer.glsl"
#include "fog.glsl"
#define ALL_PIXELS
#include "tonemap.glsl"

layout(constant_id = ID_LIGHT_ALPHA) const bool LIGHT_ALPHA = true; // else depth tells surfaces from the background

layout(set = SET_INPUTS, binding = INPUT_LIGHT, input_attachment_index = INPUT_LIGHT)
    uniform inputAttachment input_light;
layout(set = SET_INPUTS, binding = INPUT_SPECULAR_LIGHT, input_attachment_index = INPUT_SPECULAR_LIGHT)
    uniform inputAttachment input_specular_light;

layout(location = TARGET_OUTPUT) out vec4 target_output;

// Light and, in alpha, whether it is of a surface.
vec4 summed_light() {
    vec4 light = LIGHT_READ ? gbuffer_read_light(FOG || BACKGROUND) : input_load(input_light);
    if (SPLIT_LIGHT) {
        light = vec4(light.rgb * gbuffer_read().diffuse, 0.0) + input_load(input_specular_light);
    }
    return light;
}

bool is_background(vec4 light) {
    // Surfaces write alpha 1, and lights add 0 to it.
    return (LIGHT_ALPHA ? light.a : input_load(input_depth).r) == 0.0;
}

vec3 exposed_light_of(vec4 light, bool is_background) {
    vec3 exposed_light = light.rgb / frame.light_scale;
    if (FOG && !is_background) {
        exposed_light = fogged(exposed_light, gbuffer_read().position_world);
    }
    return exposed_light;
}

#ifdef MULTISAMPLED

// A pixel is the mean of its samples' display light: bright samples that the curve takes to white weigh as much as others, so that
// edges are as smooth as they look (Persson, "Post-Tonemapping Resolve for High-Quality HDR Antialiasing in D3D10", ShaderX6).
// RESOLVE_PLAIN: the curve of their mean light. All samples get it, so that the attachment's resolve changes nothing.
layout(constant_id = ID_RESOLVE_PLAIN) const bool RESOLVE_PLAIN = false;

void main() {
    vec3 sum = vec3(0.0);
    vec3 exposed_sum = vec3(0.0);
    vec3 display = vec3(0.0);
    vec3 last = vec3(-1.0);
    int surfaces = 0;
    for (int i = 0; i < SAMPLE_COUNT; ++i) {
        input_sample = i;
        vec4 light = summed_light();
        bool is_background = is_background(light);
        if (BACKGROUND && is_background && !BLOOM) {
            sum += background_color().rgb;
            continue;
        }
        vec3 exposed_light = with_bloom(whole_light(exposed_light_of(light, is_background), is_background));
        surfaces += 1;
        if (RESOLVE_PLAIN) {
            exposed_sum += exposed_light;
            continue;
        }
        // Most pixels have but one light.
        if (exposed_light != last) {
            last = exposed_light;
            display = stored(tonemap(exposed_light));
        }
        sum += display;
    }
    if (RESOLVE_PLAIN && surfaces > 0) {
        sum += stored(tonemap(exposed_sum / float(surfaces))) * float(surfaces);
    }
    vec3 mean = sum / float(SAMPLE_COUNT);
    target_output = vec4(DITHER && surfaces > 0 ? dither(mean) : mean, 1.0);
}

#else

void main() {
    vec4 light = summed_light();
    bool is_background = is_background(light);
    vec3 exposed_light = exposed_light_of(light, is_background);
    target_output = whole_color(exposed_light, is_background);
}

#endif
