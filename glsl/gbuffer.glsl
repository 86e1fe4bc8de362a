// The G-buffer: what geometry writes of a surface, and later stages read. A pipeline has one of the forms, and of the targets and
// inputs those that this form has; the rest is removed when it is made. Wants frame.glsl and pixel.glsl.

#include "gbuffer/surface.glsl"
#include "gbuffer/normal.glsl"
#include "gbuffer/color.glsl"
#include "gbuffer/small_float.glsl"

layout(constant_id = ID_FORM) const uint FORM = FORM_METALLIC;

// Whether it has depth, and no position.
const bool HAS_DEPTH = FORM == FORM_METALLIC || FORM == FORM_SPECULAR || FORM == FORM_RASA128 || FORM == FORM_PACKED128;

// What EDGE_TARGET holds of a fragment: 0 that its triangle covers the pixel, 1 that it does not; and between them that an alpha
// mask may have cut it.
const float EDGE_MASKED = 0.5;
const float EDGE_PERHAPS = 0.75;

// Whether diffuse light is summed by itself, and albedo applied in the last stage.
const bool SPLIT_LIGHT = FORM == FORM_RASA128;

#ifdef SUBPASS_GEOMETRY

layout(constant_id = ID_DEPTH_TARGET) const bool DEPTH_TARGET = false; // else depth is read from the depth attachment

layout(location = TARGET_DEPTH) out float target_depth;
layout(location = TARGET_POSITION) out vec4 target_position;
layout(location = TARGET_POSITION_Z) out float target_position_z;
layout(location = TARGET_NORMAL_ROUGHNESS) out vec4 target_normal_roughness;
layout(location = TARGET_NORMAL) out vec4 target_normal;
layout(location = TARGET_NORMAL_XY) out vec2 target_normal_xy;
layout(location = TARGET_BASE_METALLIC) out vec4 target_base_metallic;
layout(location = TARGET_SPECULAR) out vec4 target_specular;
layout(location = TARGET_WORDS) out uvec4 target_words;
layout(location = TARGET_MORE_WORDS) out uvec4 target_more_words;
layout(location = TARGET_LIGHT_WORD) out uvec2 target_light_word;

layout(location = TARGET_EDGE) out float target_edge;
layout(constant_id = ID_EDGE_TARGET) const bool EDGE_TARGET = false;

// The coverage itself, of which centroid interpolation is but a hint: drivers may leave the centre's value wherever the centre is
// covered (Thibieroz, "Deferred Shading with Multisampling Anti-Aliasing in DirectX 10", ShaderX7, 2.8).
void write_edge(bool is_masked) {
    if (EDGE_TARGET) {
        bool is_covered = gl_SampleMaskIn[0] == (1 << SAMPLE_COUNT) - 1;
        target_edge = !is_covered ? 1.0 : is_masked ? EDGE_MASKED : 0.0;
    }
}

layout(location = TARGET_OCCLUSION) out float target_occlusion;

void write_occlusion(float occlusion) {
    if (OCCLUSION_TARGET) {
        target_occlusion = occlusion;
    }
}

void write_depth() {
    if (DEPTH_TARGET) {
        target_depth = gl_FragCoord.z;
    }
}

#else

#ifdef SUBPASS_DECALS
// What of a surface is written over what was read of it.
layout(location = TARGET_POSITION) out vec4 target_position;
layout(location = TARGET_NORMAL_ROUGHNESS) out vec4 target_normal_roughness;
layout(location = TARGET_NORMAL) out vec4 target_normal;
layout(location = TARGET_NORMAL_XY) out vec2 target_normal_xy;
layout(location = TARGET_BASE_METALLIC) out vec4 target_base_metallic;
layout(location = TARGET_SPECULAR) out vec4 target_specular;
layout(location = TARGET_WORDS) out uvec4 target_words;
layout(location = TARGET_MORE_WORDS) out uvec4 target_more_words;
#endif

#ifdef SUBPASS_LIGHTING
// What holds light, written over what was read of it.
layout(location = TARGET_WORDS) out uvec4 target_words;
layout(location = TARGET_MORE_WORDS) out uvec4 target_more_words;
layout(location = TARGET_LIGHT_WORD) out uvec2 target_light_word;
#endif

layout(INPUT_AT(INPUT_DEPTH)) uniform inputAttachment input_depth;
layout(INPUT_AT(INPUT_POSITION))
    uniform inputAttachment input_position;
layout(INPUT_AT(INPUT_POSITION_Z))
    uniform inputAttachment input_position_z;
layout(INPUT_AT(INPUT_NORMAL_ROUGHNESS))
    uniform inputAttachment input_normal_roughness;
layout(INPUT_AT(INPUT_NORMAL))
    uniform inputAttachment input_normal;
layout(INPUT_AT(INPUT_NORMAL_XY))
    uniform inputAttachment input_normal_xy;
layout(INPUT_AT(INPUT_BASE_METALLIC))
    uniform inputAttachment input_base_metallic;
layout(INPUT_AT(INPUT_SPECULAR))
    uniform inputAttachment input_specular;
layout(INPUT_AT(INPUT_WORDS))
    uniform uinputAttachment input_words;
layout(INPUT_AT(INPUT_MORE_WORDS))
    uniform uinputAttachment input_more_words;
layout(INPUT_AT(INPUT_LIGHT_WORD))
    uniform uinputAttachment input_light_word;

layout(INPUT_AT(INPUT_OCCLUSION))
    uniform inputAttachment input_occlusion;

float gbuffer_read_occlusion() {
    return OCCLUSION_TARGET ? input_load(input_occlusion).r : 1.0;
}

vec3 read_position() {
#if defined(MULTISAMPLED) && defined(SUBPASS_LIGHTING)
    if (SAMPLE_DEPTH && !PER_SAMPLE) {
        // That of the pixel's centre, around which samples are placed evenly: depth is linear over a triangle.
        float sum = 0.0;
        for (int i = 0; i < SAMPLE_COUNT; ++i) {
            sum += subpassLoad(input_depth, i).r;
        }
        return position_world(sum / float(SAMPLE_COUNT));
    }
#endif
    return position_world(input_load(input_depth).r);
}

#endif

#include "gbuffer/light.glsl"
#include "gbuffer/paint.glsl"
#include "gbuffer/metallic.glsl"
#include "gbuffer/specular.glsl"
#include "gbuffer/thibieroz128.glsl"
#include "gbuffer/thibieroz96.glsl"
#include "gbuffer/rasa128.glsl"
#include "gbuffer/dissertation192.glsl"
#include "gbuffer/light_words.glsl"
#include "gbuffer/metallic256.glsl"
#include "gbuffer/specular256.glsl"
#include "gbuffer/packed128.glsl"

#ifdef SUBPASS_GEOMETRY

// `light`: for the forms that hold it; alpha 1 is a surface, 0 the background.
void gbuffer_write(Surface surface, vec3 base_color, float metallic, vec4 light) {
    if (FORM == FORM_METALLIC) {
        write_metallic(surface, base_color, metallic);
    } else if (FORM == FORM_SPECULAR) {
        write_specular(surface);
    } else if (FORM == FORM_THIBIEROZ128) {
        write_thibieroz128(surface, base_color, metallic);
    } else if (FORM == FORM_THIBIEROZ96) {
        write_thibieroz96(surface, base_color);
    } else if (FORM == FORM_RASA128) {
        write_rasa128(surface);
    } else if (FORM == FORM_DISSERTATION192) {
        write_dissertation192(surface, base_color, metallic);
    } else if (FORM == FORM_METALLIC256) {
        write_metallic256(surface, base_color, metallic, light);
    } else if (FORM == FORM_SPECULAR256) {
        write_specular256(surface, light);
    } else {
        write_packed128(surface, base_color, metallic, light);
    }
}

#else

Surface gbuffer_read() {
    if (FORM == FORM_METALLIC) {
        return read_metallic();
    } else if (FORM == FORM_SPECULAR) {
        return read_specular();
    } else if (FORM == FORM_THIBIEROZ128) {
        return read_thibieroz128();
    } else if (FORM == FORM_THIBIEROZ96) {
        return read_thibieroz96();
    } else if (FORM == FORM_RASA128) {
        return read_rasa128();
    } else if (FORM == FORM_DISSERTATION192) {
        return read_dissertation192();
    } else if (FORM == FORM_METALLIC256) {
        return read_metallic256();
    } else if (FORM == FORM_SPECULAR256) {
        return read_specular256();
    }
    return read_packed128();
}

// Exposed light * light_scale so far, of the forms that hold it; alpha 1 is a surface, 0 the background, where it is to tell.
vec4 gbuffer_read_light(bool tell_background) {
    if (FORM == FORM_METALLIC256) {
        return read_light_metallic256();
    } else if (FORM == FORM_SPECULAR256) {
        return read_light_specular256();
    }
    return read_light_packed128(tell_background);
}

// Base colour and metallicness of the surface: what forms that store products of both take them to be.
vec4 gbuffer_read_base_metallic() {
    if (FORM == FORM_SPECULAR || FORM == FORM_RASA128 || FORM == FORM_SPECULAR256) {
        Surface surface = gbuffer_read();
        return base_metallic_of(surface.diffuse, surface.f0);
    } else if (FORM == FORM_METALLIC256) {
        return base_metallic_metallic256();
    } else if (FORM == FORM_PACKED128) {
        return base_metallic_packed128();
    }
    vec4 base_metallic = input_load(input_base_metallic);
    return vec4(decode_color(base_metallic.rgb), FORM == FORM_THIBIEROZ96 ? 0.0 : base_metallic.a);
}

#ifdef SUBPASS_DECALS

// Writes the painted channels; all else stays as it is, to the bit.
void gbuffer_paint(Paint paint) {
    if (FORM == FORM_METALLIC) {
        paint_metallic(paint);
    } else if (FORM == FORM_SPECULAR) {
        paint_specular(paint);
    } else if (FORM == FORM_THIBIEROZ128) {
        paint_thibieroz128(paint);
    } else if (FORM == FORM_THIBIEROZ96) {
        paint_thibieroz96(paint);
    } else if (FORM == FORM_RASA128) {
        paint_rasa128(paint);
    } else if (FORM == FORM_DISSERTATION192) {
        paint_dissertation192(paint);
    } else if (FORM == FORM_METALLIC256) {
        paint_metallic256(paint);
    } else if (FORM == FORM_SPECULAR256) {
        paint_specular256(paint);
    } else {
        paint_packed128(paint);
    }
}

#endif

#ifdef SUBPASS_LIGHTING

// Adds to that, and leaves all else of the words as it is.
void gbuffer_add_light(vec3 light) {
    if (FORM == FORM_METALLIC256 || FORM == FORM_SPECULAR256) {
        add_light_words(light);
    } else {
        add_light_packed128(light);
    }
}

#endif

#endif
