// What every shader may use.

#include "shared.h"

// Input attachments have a value a pixel or, in modules compiled with MULTISAMPLED, one a sample: `input_load` reads that of
// `input_sample`. There a fragment is a pixel, which reads sample 0 unless it goes through all of them, or (PER_SAMPLE) a sample,
// which reads its own.
// Modules compiled with INPUTS_SAMPLED are of later passes, and read any pixel of what was stored: that at `input_place`.
#ifdef INPUTS_SAMPLED
#define INPUT_AT(number) set = SET_INPUTS, binding = number
#else
#define INPUT_AT(number) set = SET_INPUTS, binding = number, input_attachment_index = number
#endif

layout(constant_id = ID_SAMPLE_COUNT) const int SAMPLE_COUNT = 1;
#ifdef INPUTS_SAMPLED
#define inputAttachment sampler2D
#define uinputAttachment usampler2D
ivec2 input_place = ivec2(0);
#define input_load(input) texelFetch(input, input_place, 0)
#elif defined(MULTISAMPLED)
layout(constant_id = ID_PER_SAMPLE) const bool PER_SAMPLE = false;
layout(constant_id = ID_SAMPLE_DEPTH) const bool SAMPLE_DEPTH = false; // depth differs by sample: that of the depth attachment
#define inputAttachment subpassInputMS
#define uinputAttachment usubpassInputMS
int input_sample = 0;
#define input_load(input) subpassLoad(input, input_sample)
#else
#define inputAttachment subpassInput
#define uinputAttachment usubpassInput
#define input_load(input) subpassLoad(input)
#endif

const float PI = 3.14159265358979323846;

// Unit length; the zero vector stays zero instead of becoming NaN.
vec3 unit(vec3 v) {
    const float smallest_normal = 1.17549435e-38;
    return v * inversesqrt(max(dot(v, v), smallest_normal));
}
