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

layout(constant_id = ID_TRANSLUCENCY) const bool TRANSLUCENCY = false; // alpha: how much of the background is covered

layout(set = SET_INPUTS, binding = INPUT_LIGHT, input_attachment_index = INPUT_LIGHT)
    uniform inputAttachment input_light;
layout(set = SET_INPUTS, binding = INPUT_SPECULAR_LIGHT, input_attachment_index = INPUT_SPECULAR_LIGHT)
    uniform inputAttachment input_specular_light;

layout(location = TARGET_OUTPUT) out vec4 target_output;

// Light and, in alpha, whether it is of a surface.
vec4 summed_light() {
    vec4 light = LIGHT_READ ? gbuffer_read_light(FOG || BACKGROUND) : input_load(input_light);
    if (SPLIT_LIGHT) {
        // What no light reaches may have been written by nothing.
        bvec3 dark = equal(light.rgb, vec3(0.0));
        vec3 diffuse = mix(light.rgb * gbuffer_read().diffuse, vec3(0.0), dark);
        light = vec4(diffuse, 0.0) + input_load(input_specular_light);
    }
    return light;
}

bool is_background(vec4 light) {
    // Surfaces write alpha 1, and lights add 0 to it.
    return (LIGHT_ALPHA ? light.a : input_load(input_depth).r) == 0.0;
}

// The part of the background that is seen: it is a colour of the display, on which what is blended lies as a picture on a page.
float uncovered(vec4 light, bool is_background) {
    return TRANSLUCENCY ? 1.0 - light.a : is_background ? 1.0 : 0.0;
}

vec3 exposed_light_of(vec4 light, bool is_background) {
    vec3 exposed_light = light.rgb / frame.light_scale;
    if (FOG && !is_background) {
        exposed_light = fogged(exposed_light, gbuffer_read().position_world);
    }
    return exposed_light;
}

// With what bloom takes of the background for light.
vec3 over_background(vec3 exposed_light, vec4 light, bool is_background) {
    if (!(BACKGROUND && TRANSLUCENCY)) {
        return whole_light(exposed_light, is_background);
    }
    return BLOOM ? exposed_light + tonemap_inverse(background_color().rgb) * uncovered(light, is_background) : exposed_light;
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
        if (BACKGROUND && !BLOOM) {
            sum += background_color().rgb * uncovered(light, is_background);
            if (is_background) {
                continue;
            }
        }
        vec3 exposed_light = with_bloom(over_background(exposed_light_of(light, is_background), light, is_background));
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
    if (BACKGROUND && TRANSLUCENCY) {
        vec3 over = output_color(with_bloom(over_background(exposed_light, light, is_background))).rgb;
        vec3 behind = BLOOM ? vec3(0.0) : background_color().rgb * uncovered(light, is_background);
        target_output = vec4(over + behind, 1.0);
        return;
    }
    target_output = whole_color(exposed_light, is_background);
}

#endif
