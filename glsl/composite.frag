#version 450
// Lays what was collected of blended surfaces over the light.
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "gbuffer/surface.glsl"

#define LAYER_SET SET_INPUTS
#include "layers.glsl"

layout(constant_id = ID_COLLECTED) const uint COLLECTED = COLLECTED_LAYERS;
layout(constant_id = ID_FORM) const uint FORM = FORM_METALLIC;
const bool SPLIT_LIGHT = FORM == FORM_RASA128;
#include "gbuffer/light_target.glsl"

layout(set = SET_INPUTS, binding = INPUT_WEIGHTED_LIGHT, input_attachment_index = INPUT_WEIGHTED_LIGHT)
    uniform inputAttachment input_weighted_light;
layout(set = SET_INPUTS, binding = INPUT_WEIGHTS, input_attachment_index = INPUT_WEIGHTS) uniform inputAttachment input_weights;

vec4 layers_light() {
    Layers layers = layers_read();
    vec4 light = layer_light(layers.a);
    if (LAYER_COUNT > 1) {
        light = layer_over(light, layer_light(layers.b));
    }
    if (LAYER_COUNT > 2) {
        light = layer_over(light, layer_light(layers.c));
    }
    if (LAYER_COUNT > 3) {
        light = layer_over(light, layer_light(layers.d));
    }
    return light;
}

// The mean by weight of all layers, over the part of what is behind that they cover together.
vec4 mean_light() {
    const float LEAST = 1e-7;
    vec4 sum = input_load(input_weighted_light);
    float covered = 1.0 - sum.a;
    return vec4(sum.rgb / max(input_load(input_weights).r, LEAST) * covered, covered);
}

void main() {
#ifdef MULTISAMPLED
    input_sample = PER_SAMPLE ? gl_SampleID : 0;
#endif
    light_over(COLLECTED == COLLECTED_SUM ? mean_light() : layers_light());
}
