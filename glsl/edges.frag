#version 450
// Marks in the stencil the pixels whose samples are to be lit one by one: those whose samples differ in what lighting reads of
// them. EDGE_TARGET: those that geometry said had triangles over some of their samples only; where an alpha mask was, which no
// triangle's outline tells of, samples are compared all the same.
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "frame.glsl"
#include "pixel.glsl"
#include "gbuffer.glsl"

layout(constant_id = ID_EDGE_TARGET) const bool EDGE_TARGET = false;
layout(constant_id = ID_EDGE_MASKS) const bool EDGE_MASKS = false; // some surfaces have alpha masks

layout(set = SET_INPUTS, binding = INPUT_EDGE, input_attachment_index = INPUT_EDGE) uniform inputAttachment input_edge;

// Whether two samples are lit alike. What geometry stored once for all samples that a triangle covers is the same to the bit.
#define SAME(input) (subpassLoad(input, i) == subpassLoad(input, 0))

bool has_same_surface(int i) {
    bool same = true;
    if (FORM == FORM_METALLIC || FORM == FORM_SPECULAR) {
        same = SAME(input_normal_roughness) && SAME(input_base_metallic);
    }
    if (FORM == FORM_SPECULAR || FORM == FORM_RASA128) {
        same = same && SAME(input_specular);
    }
    if (FORM == FORM_RASA128) {
        same = same && SAME(input_normal) && SAME(input_base_metallic);
    }
    if (FORM == FORM_THIBIEROZ128 || FORM == FORM_DISSERTATION192) {
        same = SAME(input_position) && SAME(input_normal) && SAME(input_base_metallic);
    }
    if (FORM == FORM_THIBIEROZ96) {
        same = SAME(input_position) && SAME(input_position_z) && SAME(input_normal_xy) && SAME(input_base_metallic);
    }
    if (FORM == FORM_METALLIC256 || FORM == FORM_SPECULAR256 || FORM == FORM_PACKED128) {
        same = SAME(input_words);
    }
    if (FORM == FORM_METALLIC256 || FORM == FORM_SPECULAR256) {
        same = same && SAME(input_more_words);
    }
    if (FORM == FORM_PACKED128 && LIGHT_READ) {
        same = same && SAME(input_light_word);
    }
    if (HAS_DEPTH && !SAMPLE_DEPTH) {
        same = same && SAME(input_depth);
    }
    if (OCCLUSION_TARGET) {
        same = same && SAME(input_occlusion);
    }
    return same;
}

// Whether samples of one surface are on one plane, as far as a pixel can tell: no further apart than it slopes over the pixel, and
// the pixel's own size.
bool is_flat() {
    Surface surface = gbuffer_read();
    float depth = subpassLoad(input_depth, 0).r;
    float nearest = distance_of(depth);
    float farthest = nearest;
    for (int i = 1; i < SAMPLE_COUNT; ++i) {
        float distance = distance_of(subpassLoad(input_depth, i).r);
        nearest = min(nearest, distance);
        farthest = max(farthest, distance);
    }
    float grows = mix(1.0, farthest, frame.camera_position_world.w);
    vec3 right = frame.right_world.xyz * (2.0 * frame.inverse_size.x * grows);
    vec3 down = frame.down_world.xyz * (2.0 * frame.inverse_size.y * grows);
    float along = abs(dot(surface.normal_world, ray_world()));
    float across = abs(dot(surface.normal_world, right)) + abs(dot(surface.normal_world, down));
    return !surface.lit || (farthest - nearest - length(down)) * along <= across;
}

bool is_edge() {
    for (int i = 1; i < SAMPLE_COUNT; ++i) {
        if (!has_same_surface(i)) {
            return true;
        }
    }
    return SAMPLE_DEPTH && !is_flat();
}

void main() {
    bool is_marked = false;
    if (EDGE_TARGET) {
        float most = 0.0;
        for (int i = 0; i < SAMPLE_COUNT; ++i) {
            most = max(most, subpassLoad(input_edge, i).r);
        }
        is_marked = most > EDGE_PERHAPS || (EDGE_MASKS && most > 0.0 && is_edge());
    } else {
        is_marked = is_edge();
    }
    if (!is_marked) {
        discard;
    }
}
