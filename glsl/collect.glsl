// What a blended surface leaves to be composed when all are drawn. `light` is exposed * light_scale, multiplied by alpha.

#define LAYER_SET SET_LAYERS
#include "layers.glsl"

layout(constant_id = ID_COLLECTED) const uint COLLECTED = COLLECTED_NOT;

layout(location = TARGET_LAYER_0) out uvec4 target_layer_0;
layout(location = TARGET_LAYER_1) out uvec4 target_layer_1;
layout(location = TARGET_LAYER_2) out uvec4 target_layer_2;
layout(location = TARGET_LAYER_3) out uvec4 target_layer_3;
layout(location = TARGET_WEIGHTED_LIGHT) out vec4 target_weighted_light;
layout(location = TARGET_WEIGHTS) out vec4 target_weights;

// Puts the nearer one into `layer`, and leaves the other. Of equals the one drawn last is nearer.
void layer_sort(inout uvec2 layer, inout uvec2 fragment) {
    bool nearer = fragment.y >> 8 >= layer.y >> 8;
    uvec2 other = nearer ? layer : fragment;
    layer = nearer ? fragment : layer;
    fragment = other;
}

// What there is no layer for is merged with the last.
uvec2 layer_merged(uvec2 layer, uvec2 rest) {
    vec4 both = layer_over(layer_light(layer), layer_light(rest));
    uint alpha = uint(both.a * 255.0 + 0.5);
    return rest.y == 0u ? layer : uvec2(e5b9g9r9_of(both.rgb), (layer.y & ~255u) | alpha);
}

void collect_layer(vec4 light, float depth) {
    Layers layers = layers_read();
    uvec2 rest = layer_of(light, depth);
    layer_sort(layers.a, rest);
    if (LAYER_COUNT > 1) {
        layer_sort(layers.b, rest);
    }
    if (LAYER_COUNT > 2) {
        layer_sort(layers.c, rest);
    }
    if (LAYER_COUNT > 3) {
        layer_sort(layers.d, rest);
    }
    if (LAYER_COUNT == 1) {
        layers.a = layer_merged(layers.a, rest);
    } else if (LAYER_COUNT == 2) {
        layers.b = layer_merged(layers.b, rest);
    } else if (LAYER_COUNT == 3) {
        layers.c = layer_merged(layers.c, rest);
    } else {
        layers.d = layer_merged(layers.d, rest);
    }
    if (LAYER_PAIRS) {
        target_layer_0 = uvec4(layers.a, layers.b);
        if (LAYER_COUNT > 2) {
            target_layer_1 = uvec4(layers.c, layers.d);
        }
        return;
    }
    target_layer_0 = uvec4(layers.a, 0u, 0u);
    if (LAYER_COUNT > 1) {
        target_layer_1 = uvec4(layers.b, 0u, 0u);
    }
    if (LAYER_COUNT > 2) {
        target_layer_2 = uvec4(layers.c, 0u, 0u);
    }
    if (LAYER_COUNT > 3) {
        target_layer_3 = uvec4(layers.d, 0u, 0u);
    }
}

// McGuire and Bavoil 2013, "Weighted Blended Order-Independent Transparency", equation 7 with `distance` along the view in metres.
// Half floats hold the sum of what is at most MOST_WEIGHT times as bright.
void collect_sum(vec4 light, float distance) {
    const float MOST_WEIGHT = 100.0;
    float near = distance / 5.0;
    float far = distance / 200.0;
    float weight = clamp(10.0 / (1e-5 + near * near + pow(far, 6.0)), 1e-2, MOST_WEIGHT) * light.a;
    target_weighted_light = vec4(min(light.rgb * weight, vec3(6.0e4)), light.a);
    target_weights = vec4(light.a * weight, 0.0, 0.0, light.a);
}
