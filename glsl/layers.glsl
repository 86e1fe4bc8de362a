// Layers of what is blended, kept apart in each pixel until all is drawn: multi-layer alpha blending (Salvi and Vaidyanathan 2014,
// "Multi-Layer Alpha Blending", I3D). A layer is two words:
//   x  light * alpha, exposed * light_scale (e5b9g9r9)
//   y  depth, 24 bits of a float of which 17 are its mantissa; alpha, 8 bits
// Depth is reversed: what is nearer has more. Words of 0 are a layer that is clear and behind all others.
// The includer says in which set its inputs are: LAYER_SET.

#include "gbuffer/small_float.glsl"

layout(constant_id = ID_LAYER_COUNT) const uint LAYER_COUNT = 4;
layout(constant_id = ID_LAYER_PAIRS) const bool LAYER_PAIRS = false; // two in each attachment, which has four words

layout(set = LAYER_SET, binding = INPUT_LAYER_0, input_attachment_index = INPUT_LAYER_0) uniform uinputAttachment input_layer_0;
layout(set = LAYER_SET, binding = INPUT_LAYER_1, input_attachment_index = INPUT_LAYER_1) uniform uinputAttachment input_layer_1;
layout(set = LAYER_SET, binding = INPUT_LAYER_2, input_attachment_index = INPUT_LAYER_2) uniform uinputAttachment input_layer_2;
layout(set = LAYER_SET, binding = INPUT_LAYER_3, input_attachment_index = INPUT_LAYER_3) uniform uinputAttachment input_layer_3;

struct Layers {
    uvec2 a; // from near to far
    uvec2 b;
    uvec2 c;
    uvec2 d;
};

Layers layers_read() {
    Layers layers = Layers(uvec2(0u), uvec2(0u), uvec2(0u), uvec2(0u));
    uvec4 words = input_load(input_layer_0);
    layers.a = words.xy;
    if (LAYER_PAIRS) {
        layers.b = words.zw;
        if (LAYER_COUNT > 2) {
            words = input_load(input_layer_1);
            layers.c = words.xy;
            layers.d = words.zw;
        }
        return layers;
    }
    if (LAYER_COUNT > 1) {
        layers.b = input_load(input_layer_1).xy;
    }
    if (LAYER_COUNT > 2) {
        layers.c = input_load(input_layer_2).xy;
    }
    if (LAYER_COUNT > 3) {
        layers.d = input_load(input_layer_3).xy;
    }
    return layers;
}

uvec2 layer_of(vec4 light, float depth) {
    uint alpha = uint(clamp(light.a, 0.0, 1.0) * 255.0 + 0.5);
    return uvec2(e5b9g9r9_of(light.rgb), floatBitsToUint(depth) >> 6 << 8 | alpha);
}

vec4 layer_light(uvec2 layer) {
    return vec4(from_e5b9g9r9(layer.x), float(layer.y & 255u) / 255.0);
}

// What is before and what is behind it.
vec4 layer_over(vec4 before, vec4 behind) {
    return before + behind * (1.0 - before.a);
}
