#version 450
// All lights on one pixel, or (ONE_LIGHT) only the one whose volume is drawn. FOLD: tonemaps and writes the output; else
// fixed-function blending adds to the light target.
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "frame.glsl"
#include "pixel.glsl"
#include "gbuffer.glsl"
#include "brdf.glsl"
#include "light/direct.glsl"
#include "fog.glsl"
#include "tonemap.glsl"

layout(constant_id = ID_FOLD) const bool FOLD = false;
layout(constant_id = ID_ONE_LIGHT) const bool ONE_LIGHT = false;

layout(location = VARYING_LIGHT) flat in uint varying_light;

layout(location = TARGET_OUTPUT) out vec4 target_output;

void main() {
    Surface surface = gbuffer_read();
    vec3 exposed_light = vec3(0.0);
    if (surface.lit) {
        vec3 position = position_world(surface.depth);
        vec3 v = view_direction_world();
        vec3 light = vec3(0.0);
        if (!ONE_LIGHT) {
            light = direct_light(surface, position, v);
        } else if (is_lit_from(varying_light, surface, position)) {
            light = light_reflected(varying_light, surface, reflector(surface, v), position);
        }
        exposed_light = light * frame.exposure;
        if (FOG) {
            exposed_light = fogged(exposed_light, position);
        }
    }
    // Pixels that are not lit add 0. `discard` would save tilers nothing, since blending stays on the tile, but it
    // makes a fragment's coverage depend on its shader, which costs Mali its early kills and PowerVR its deferral.
    // Folded, there is no one else to write the background: the surfaces that are not lit.
    if (FOLD) {
        target_output = BACKGROUND && !surface.lit ? background_color() : output_color(exposed_light);
    } else {
        target_output = vec4(exposed_light * frame.light_scale, 0.0);
    }
}
