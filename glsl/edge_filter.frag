#version 450
// Averages pixels on edges with their neighbours: Koonce 2007, 19.5.2 and listing 19-3. Edges are where depth changes much more to
// one side than to the other, or normals do; neither depends on the resolution. src/reference/edge_filter.rs is the same in f64.
#extension GL_GOOGLE_include_directive : require
#define INPUTS_SAMPLED
#include "common.glsl"
#include "frame.glsl"
#include "pixel.glsl"
#include "gbuffer.glsl"

layout(constant_id = ID_DEPTH_STEP) const float DEPTH_STEP = 0.0; // between neighbouring values of fixed-point depth

layout(set = SET_INPUTS, binding = BINDING_EDGE_COLOR) uniform sampler2D edge_color;

layout(location = TARGET_OUTPUT) out vec4 target_output;

// A change of depth is an edge's where it is so many times the one on the other side.
const float DEPTH_RATIO = 25.0;
// Changes below this share of the distance are rounding.
const float LEAST_CHANGE = 1e-5;
// Between the cosines of the angles to the normals on either side.
const float NORMAL_CHANGE = 0.4;
// Stands for the background's depth, at which distances without a far plane end.
const float LEAST_DEPTH = 1e-7;

float distance_from(float depth) {
    vec4 d = frame.distance_from_depth;
    float held = max(depth, LEAST_DEPTH);
    return (d.x + d.y * held) / (d.z + d.w * held);
}

vec3 normal_here() {
    Surface surface = gbuffer_read();
    return surface.lit ? surface.normal_world : vec3(0.0);
}

// 0 inside of surfaces to 1 where all directions cross an edge.
float edge_weight(ivec2 pixel) {
    // The one opposite to the n-th of the first four is the n-th of the others.
    const ivec2 offsets[8] = ivec2[](
        ivec2(-1, -1), ivec2(0, -1), ivec2(1, -1), ivec2(1, 0), ivec2(1, 1), ivec2(0, 1), ivec2(-1, 1), ivec2(-1, 0));
    ivec2 last = textureSize(edge_color, 0) - 1;
    input_place = pixel;
    float depth = input_load(input_depth).r;
    float center = distance_from(depth);
    vec3 normal = normal_here();
    float changes[8];
    float cosines[8];
    for (int i = 0; i < 8; ++i) {
        input_place = clamp(pixel + offsets[i], ivec2(0), last);
        changes[i] = abs(distance_from(input_load(input_depth).r) - center);
        cosines[i] = dot(normal_here(), normal);
    }
    float least = max(LEAST_CHANGE * center, center - distance_from(depth + DEPTH_STEP));
    float edges = 0.0;
    for (int i = 0; i < 4; ++i) {
        float small = max(min(changes[i], changes[i + 4]), least);
        bool of_depth = max(changes[i], changes[i + 4]) >= small * DEPTH_RATIO;
        bool of_normal = abs(cosines[i] - cosines[i + 4]) >= NORMAL_CHANGE;
        edges += of_depth || of_normal ? 0.25 : 0.0;
    }
    return edges;
}

void main() {
    // Samples move from the pixel's centre to its corners, where each is of four pixels.
    float reach = 0.5 * edge_weight(ivec2(gl_FragCoord.xy));
    vec4 sum = vec4(0.0);
    for (int i = 0; i < 4; ++i) {
        vec2 corner = vec2(i & 1, i >> 1) * 2.0 - 1.0;
        sum += textureLod(edge_color, (gl_FragCoord.xy + corner * reach) * frame.inverse_size, 0.0);
    }
    target_output = sum * 0.25;
}
