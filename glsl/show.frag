#version 450
// What the frame's G-buffer holds, in place of the picture: read from the tile as lighting reads it. Outputs of floats get the values
// themselves; outputs of bytes what src/plan/show.rs says of each, so that the byte is it and not light (colours and light are).
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "frame.glsl"
#include "pixel.glsl"
#include "gbuffer.glsl"
#include "brdf.glsl"
#include "light/direct.glsl"
#include "tonemap.glsl"

layout(constant_id = ID_SHOW) const uint SHOW = SHOW_NORMAL;
layout(constant_id = ID_SHOW_STRIPS) const uint SHOW_STRIPS = 0u; // with SHOW_CHANNELS: which, each in a strip of its own
layout(constant_id = ID_SHOW_STRIP_COUNT) const float SHOW_STRIP_COUNT = 1.0;
layout(constant_id = ID_SHOW_EDGE) const bool SHOW_EDGE = false; // with SHOW_EDGES: of what was marked
#define SHOWS(what) (SHOW == what || (SHOW == SHOW_CHANNELS && (SHOW_STRIPS >> what & 1u) != 0u))

layout(set = SET_INPUTS, binding = INPUT_LIGHT, input_attachment_index = INPUT_LIGHT)
    uniform inputAttachment input_light;
layout(set = SET_INPUTS, binding = INPUT_SPECULAR_LIGHT, input_attachment_index = INPUT_SPECULAR_LIGHT)
    uniform inputAttachment input_specular_light;

layout(location = TARGET_OUTPUT) out vec4 target_output;

// As the byte that is stored, not as light.
vec3 as_number(vec3 shown) {
    return FLOAT_OUTPUT ? shown : linear_from_srgb(clamp(shown, 0.0, 1.0));
}

vec3 of_surface(vec3 shown) {
    return gbuffer_read().lit ? shown : vec3(0.0);
}

vec3 shown_normal() {
    vec3 n = gbuffer_read().normal_world;
    return of_surface(FLOAT_OUTPUT ? n : as_number(n * 0.5 + 0.5));
}

// 0 in the background, which is infinitely far.
vec3 shown_depth() {
    float distance = 0.0;
    bool is_surface = false;
    if (HAS_DEPTH) {
        float depth = input_load(input_depth).r;
        distance = distance_of(depth);
        is_surface = depth > 0.0;
    } else {
        Surface surface = gbuffer_read();
        distance = dot(surface.position_world - frame.camera_position_world.xyz, frame.forward_world.xyz);
        is_surface = surface.lit;
    }
    if (!is_surface) {
        return vec3(0.0);
    }
    return FLOAT_OUTPUT ? vec3(distance) : as_number(vec3(1.0 / (1.0 + sqrt(max(distance, 0.0)))));
}

// Exposed light that geometry wrote.
vec3 shown_light() {
    vec3 light = LIGHT_READ ? gbuffer_read_light(false).rgb
        : SPLIT_LIGHT ? input_load(input_specular_light).rgb : input_load(input_light).rgb;
    light /= frame.light_scale;
    return FLOAT_OUTPUT ? light : stored(tonemap(light));
}

// How many lights lighting evaluates here: those that shine everywhere, and those listed for the pixel's cell (CLUSTERS) or that
// reach the surface.
uint light_count() {
    Surface surface = gbuffer_read();
    if (!surface.lit) {
        return 0u;
    }
    uvec4 counts = frame.light_counts * uvec4(HAS_DIRECTIONAL, HAS_POINT, HAS_SPOT, HAS_BOX);
    uint count = counts.x;
    if (CLUSTERS) {
        uvec2 list = cluster_list(surface.position_world);
        count += list.y - list.x;
    } else if (HAS_PLACED) {
        uint end = counts.x + counts.y + counts.z + counts.w;
        for (uint i = counts.x; i < end; ++i) {
            count += is_lit_from(i, surface, surface.position_world) ? 1u : 0u;
        }
    }
    return count;
}

// A step of the legend: src/plan/show.rs has the same.
vec3 step_of_heat(uint index) {
    const vec3 steps[6] = vec3[](
        vec3(0.0), vec3(0.1, 0.2, 0.8), vec3(0.0, 0.7, 0.6), vec3(0.9, 0.9, 0.1), vec3(0.9, 0.2, 0.1), vec3(1.0));
    return steps[index];
}

vec3 shown_lights() {
    uint count = light_count();
    if (FLOAT_OUTPUT) {
        return vec3(count);
    }
    float at = min(log2(1.0 + float(count)) * (5.0 / float(SHOW_HEAT_DOUBLINGS)), 5.0);
    uint index = min(uint(at), 4u);
    return as_number(mix(step_of_heat(index), step_of_heat(index + 1u), at - float(index)));
}

vec3 shown() {
    if (SHOW == SHOW_EDGES) {
        return vec3(SHOW_EDGE ? 1.0 : 0.0);
    }
    uint strip = 0u;
    if (SHOW == SHOW_CHANNELS) {
        strip = uint(gl_FragCoord.x * frame.inverse_size.x * SHOW_STRIP_COUNT);
    }
    uint next = 0u;
    if (SHOWS(SHOW_BASE_COLOR)) {
        if (strip == next++) {
            return of_surface(gbuffer_read_base_metallic().rgb);
        }
    }
    if (SHOWS(SHOW_METALLIC)) {
        if (strip == next++) {
            return of_surface(as_number(gbuffer_read_base_metallic().aaa));
        }
    }
    if (SHOWS(SHOW_DIFFUSE)) {
        if (strip == next++) {
            return of_surface(gbuffer_read().diffuse);
        }
    }
    if (SHOWS(SHOW_REFLECTANCE)) {
        if (strip == next++) {
            return of_surface(gbuffer_read().f0);
        }
    }
    if (SHOWS(SHOW_NORMAL)) {
        if (strip == next++) {
            return shown_normal();
        }
    }
    if (SHOWS(SHOW_ROUGHNESS)) {
        if (strip == next++) {
            return of_surface(as_number(vec3(gbuffer_read().roughness)));
        }
    }
    if (SHOWS(SHOW_DEPTH)) {
        if (strip == next++) {
            return shown_depth();
        }
    }
    if (SHOWS(SHOW_OCCLUSION)) {
        if (strip == next++) {
            return of_surface(as_number(vec3(gbuffer_read_occlusion())));
        }
    }
    if (SHOWS(SHOW_LIGHT)) {
        if (strip == next++) {
            return shown_light();
        }
    }
    if (SHOWS(SHOW_LIGHTS)) {
        return shown_lights();
    }
    return vec3(0.0);
}

void main() {
    vec3 sum = shown();
#ifdef MULTISAMPLED
    // All samples get their mean, as they do of the tone curve.
    if (SHOW != SHOW_EDGES) {
        for (int i = 1; i < SAMPLE_COUNT; ++i) {
            input_sample = i;
            sum += shown();
        }
        sum /= float(SAMPLE_COUNT);
    }
#endif
    target_output = vec4(sum, 1.0);
}
