// Light that lens and eye scatter, mixed in before the tone curve. What is scattered is what an earlier frame sent, spread by
// bloom.frag: this frame's own is known only once all of its pixels are. Scattering moves light and adds none.

layout(constant_id = ID_BLOOM) const bool BLOOM = false;
layout(constant_id = ID_BLOOM_STORED) const bool BLOOM_STORED = false; // light before the curve is stored for the next frame

layout(set = SET_INPUTS, binding = BINDING_BLOOM) uniform sampler2D bloom; // half the picture's size, rounded up

layout(location = TARGET_BLOOM_LIGHT) out vec4 target_bloom_light;

// Eight sizes of it add up to less than B10G11R11 holds in its shortest channel: an infinity would spread over the picture.
const float BLOOM_MOST = 8000.0;

vec3 with_bloom(vec3 exposed_light) {
    if (BLOOM_STORED) {
        // To the nearest, whatever the device does.
        target_bloom_light = vec4(from_b10g11r11(b10g11r11_of(clamp(exposed_light, 0.0, BLOOM_MOST))), 1.0);
    }
    if (!BLOOM) {
        return exposed_light;
    }
    // Texel i is of the pixels 2 i and 2 i + 1, also where an odd size leaves the last with one.
    vec2 place = gl_FragCoord.xy * 0.5 / vec2(textureSize(bloom, 0));
    vec3 scattered = texture(bloom, place).rgb * frame.bloom.y;
    return mix(exposed_light, scattered, frame.bloom.x);
}
