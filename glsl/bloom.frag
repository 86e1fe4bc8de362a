#version 450
// One step of spreading light: to half the size, or from the next smaller size back to add this one's. All steps keep light's mean;
// the sum of all sizes is divided by their number when it is used. src/reference/bloom.rs says what becomes of it.
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "gbuffer/small_float.glsl"

layout(constant_id = ID_TONEMAP) const uint TONEMAP = TONEMAP_NEUTRAL;

#include "tonemap_inverse.glsl"

layout(constant_id = ID_BLOOM_STEP) const uint BLOOM_STEP = BLOOM_STEP_DOWN;
layout(constant_id = ID_BLOOM_DISPLAYED) const bool BLOOM_DISPLAYED = false; // the first step reads light after the curve

layout(set = SET_POST, binding = BINDING_POST_COLOR) uniform sampler2D post_color;
layout(set = SET_POST, binding = BINDING_POST_OWN) uniform sampler2D post_own; // of the target's size

layout(location = TARGET_OUTPUT) out vec4 target_output;

// Eight sizes of it add up to less than B10G11R11 holds.
const float MOST = 8000.0;

// Of the four pixels that this one takes the place of; light is averaged, not what the curve made of it.
vec3 first() {
    ivec2 last = textureSize(post_color, 0) - 1;
    ivec2 at = ivec2(gl_FragCoord.xy) * 2;
    vec3 sum = vec3(0.0);
    for (int i = 0; i < 4; ++i) {
        vec3 texel = texelFetch(post_color, min(at + ivec2(i & 1, i >> 1), last), 0).rgb;
        sum += BLOOM_DISPLAYED ? tonemap_inverse(texel) : texel;
    }
    return min(sum * 0.25, MOST);
}

// `offset` in texels of the source.
vec3 tap(vec2 center, vec2 offset) {
    return textureLod(post_color, (center + offset) / vec2(textureSize(post_color, 0)), 0.0).rgb;
}

// Jimenez, "Next Generation Post Processing in Call of Duty: Advanced Warfare", SIGGRAPH 2014: five overlapping squares of
// 4 x 4 texels, half of the weight on the one in the middle.
vec3 down() {
    vec2 center = floor(gl_FragCoord.xy) * 2.0 + 1.0;
    vec3 inner = tap(center, vec2(-1.0, -1.0)) + tap(center, vec2(1.0, -1.0)) + tap(center, vec2(-1.0, 1.0))
        + tap(center, vec2(1.0, 1.0));
    vec3 corners = tap(center, vec2(-2.0, -2.0)) + tap(center, vec2(2.0, -2.0)) + tap(center, vec2(-2.0, 2.0))
        + tap(center, vec2(2.0, 2.0));
    vec3 sides = tap(center, vec2(0.0, -2.0)) + tap(center, vec2(0.0, 2.0)) + tap(center, vec2(-2.0, 0.0))
        + tap(center, vec2(2.0, 0.0));
    return inner * 0.125 + corners * 0.03125 + sides * 0.0625 + tap(center, vec2(0.0)) * 0.125;
}

// The same talk: a tent of 3 x 3 texels of the smaller image.
vec3 up() {
    vec2 center = gl_FragCoord.xy * 0.5;
    vec3 corners = tap(center, vec2(-1.0, -1.0)) + tap(center, vec2(1.0, -1.0)) + tap(center, vec2(-1.0, 1.0))
        + tap(center, vec2(1.0, 1.0));
    vec3 sides = tap(center, vec2(0.0, -1.0)) + tap(center, vec2(0.0, 1.0)) + tap(center, vec2(-1.0, 0.0))
        + tap(center, vec2(1.0, 0.0));
    return corners * 0.0625 + sides * 0.125 + tap(center, vec2(0.0)) * 0.25;
}

void main() {
    vec3 light = BLOOM_STEP == BLOOM_STEP_FIRST ? first() : BLOOM_STEP == BLOOM_STEP_DOWN ? down() : up();
    if (BLOOM_STEP == BLOOM_STEP_UP) {
        light += texelFetch(post_own, ivec2(gl_FragCoord.xy), 0).rgb;
    }
    // To the nearest: devices may cut off, and what a dozen steps cut off is seen.
    target_output = vec4(from_b10g11r11(b10g11r11_of(light)), 1.0);
}
