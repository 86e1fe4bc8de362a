// The depth of what is opaque in this pixel, read by what is drawn over it. Wants SET_LAYERS to hold the stage's inputs.

layout(constant_id = ID_HAS_BEHIND) const bool HAS_BEHIND = false;       // else nothing is opaque
layout(constant_id = ID_BEHIND_OPAQUE) const bool BEHIND_OPAQUE = false; // lighting reads that depth too

layout(set = SET_LAYERS, binding = INPUT_DEPTH, input_attachment_index = INPUT_DEPTH) uniform inputAttachment input_depth;
layout(set = SET_LAYERS, binding = INPUT_DEPTH_TEST, input_attachment_index = INPUT_DEPTH_TEST)
    uniform inputAttachment input_depth_test;

// That of one of the pixel's samples.
float depth_behind(int index) {
#ifdef MULTISAMPLED
    input_sample = index;
#endif
    return BEHIND_OPAQUE ? input_load(input_depth).r : input_load(input_depth_test).r;
}
