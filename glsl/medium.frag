#version 450
// A surface that light goes through, in two draws of fixed-function blending: what is behind is multiplied (ABSORBS) by what is let
// through, then light of the surface itself is added.
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "frame.glsl"
#include "pixel.glsl"
#include "gbuffer/surface.glsl"
#include "brdf.glsl"
#include "fragment.glsl"
#include "light/direct.glsl"
#include "fog.glsl"
#include "behind.glsl"
#include "medium.glsl"

layout(constant_id = ID_FORM) const uint FORM = FORM_METALLIC;
layout(constant_id = ID_ABSORBS) const bool ABSORBS = false;

const bool SPLIT_LIGHT = FORM == FORM_RASA128;
#include "gbuffer/light_target.glsl"

void main() {
    Fragment fragment = surface_at_fragment();
    float alpha = clamp(fragment.alpha, 0.0, 1.0);
    if (ABSORBS) {
        vec3 through = let_through(fragment, alpha);
        // Of a background's colour, which is no light, the part that is covered has no colour.
        target_light = vec4(through, 1.0 - dot(through, vec3(1.0 / 3.0)));
        if (SPLIT_LIGHT) {
            target_specular_light = target_light;
        }
        return;
    }
    Surface surface = fragment.surface;
    surface.diffuse *= 1.0 - medium.factor;
    surface.f0 = mix(vec3(medium.f0), fragment.base_color, fragment.metallic);
    fragment.surface = surface;
    vec3 light = indirect_light(fragment) + complete(direct_light(surface, view_direction_world()), surface);
    vec3 exposed_light = light * (frame.exposure * alpha);
    if (FOG) {
        // What is behind has its fog already: that between the surface and the viewer is what is let through of it, and the rest.
        float clear = fog_transmittance(ray_origin_world(), surface.position_world);
        vec3 color = vec3(FOG_RED, FOG_GREEN, FOG_BLUE) * (frame.exposure * (1.0 - clear));
        exposed_light = exposed_light * clear + color * (1.0 - let_through(fragment, alpha));
    }
    light_over(vec4(exposed_light * frame.light_scale, 0.0));
}
