#version 450
// Keeps what is before what was found last. The depth test then finds the farthest of it.
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"

layout(constant_id = ID_BEHIND_OPAQUE) const bool BEHIND_OPAQUE = false; // what is opaque, where lighting reads its depth too

layout(set = SET_INPUTS, binding = INPUT_DEPTH, input_attachment_index = INPUT_DEPTH) uniform inputAttachment input_depth;
layout(set = SET_INPUTS, binding = INPUT_PEEL_A, input_attachment_index = INPUT_PEEL_A) uniform inputAttachment input_peel_a;

void main() {
#ifdef MULTISAMPLED
    input_sample = PER_SAMPLE ? gl_SampleID : 0;
#endif
    float behind = BEHIND_OPAQUE ? input_load(input_depth).r : input_load(input_peel_a).r;
    if (gl_FragCoord.z <= behind) {
        discard;
    }
}
