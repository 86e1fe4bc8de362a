#version 450
// Lights a material's surface as it is drawn, and writes it to the output, or (LIGHT_TARGET) to the light target, over what is there
// (BLEND) by fixed-function blending.
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "frame.glsl"
#include "pixel.glsl"
#include "gbuffer/surface.glsl"
#include "brdf.glsl"
#include "fragment.glsl"
#include "light/direct.glsl"
#include "fog.glsl"
#include "tonemap.glsl"

layout(constant_id = ID_LIGHT_TARGET) const bool LIGHT_TARGET = false;
layout(constant_id = ID_FORM) const uint FORM = FORM_METALLIC;
layout(constant_id = ID_BLEND) const bool BLEND = false;

const bool SPLIT_LIGHT = FORM == FORM_RASA128;
#include "gbuffer/light_target.glsl"
#include "collect.glsl"

layout(location = TARGET_OUTPUT) out vec4 target_output;

void main() {
#ifdef MULTISAMPLED
    input_sample = PER_SAMPLE ? gl_SampleID : 0;
#endif
    Fragment fragment = surface_at_fragment();
    Surface surface = fragment.surface;
    vec3 light = indirect_light(fragment);
    if (!UNLIT) {
        light += complete(direct_light(surface, view_direction_world()), surface);
    }
    // The fragment's light is complete.
    vec3 exposed_light = light * frame.exposure;
    if (FOG) {
        exposed_light = fogged(exposed_light, surface.position_world);
    }
    if (LIGHT_TARGET) {
        float alpha = BLEND ? clamp(fragment.alpha, 0.0, 1.0) : 1.0;
        vec4 over = vec4(exposed_light * (frame.light_scale * alpha), alpha);
        if (COLLECTED == COLLECTED_LAYERS) {
            collect_layer(over, gl_FragCoord.z);
        } else if (COLLECTED == COLLECTED_SUM) {
            vec3 from_camera = surface.position_world - frame.camera_position_world.xyz;
            collect_sum(over, dot(from_camera, frame.forward_world.xyz));
        } else {
            light_over(over);
        }
    } else {
        target_output = output_color(exposed_light);
    }
}
