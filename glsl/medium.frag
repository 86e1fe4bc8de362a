#version 450
// A surface that light goes through, in two draws of fixed-function blending: what is behind is multiplied (ABSORBS) by what is let
// through, then light of the surface itself is added. Where light is bent (REFRACTS), in one draw that replaces what is there.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
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
#include "refraction.glsl"

layout(constant_id = ID_FORM) const uint FORM = FORM_METALLIC;
layout(constant_id = ID_ABSORBS) const bool ABSORBS = false;
layout(constant_id = ID_REFRACTS) const bool REFRACTS = false;

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
    Bent bent = Bent(vec3(0.0), vec3(0.0), vec3(0.0));
    vec3 tint = vec3(0.0);
    if (REFRACTS) {
        bent = bent_light(surface);
        tint = surface_tint(fragment) * alpha;
    }
    if (FOG) {
        // What is behind has its fog already: that between the surface and the viewer is what is let through of it, and the rest.
        float clear = fog_transmittance(ray_origin_world(), surface.position_world);
        vec3 color = vec3(FOG_RED, FOG_GREEN, FOG_BLUE) * (frame.exposure * (1.0 - clear));
        vec3 through = REFRACTS ? tint * bent.left + (1.0 - alpha) : let_through(fragment, alpha);
        exposed_light = exposed_light * clear + color * (1.0 - through);
    }
    if (REFRACTS) {
        // Where alpha has no surface, what is behind is seen straight ahead.
        vec4 ahead = fetch_behind(behind_light, ivec2(gl_FragCoord.xy));
        vec3 behind = bent.light * tint + ahead.rgb * (1.0 - alpha);
        float background = dot(bent.background * tint, vec3(1.0 / 3.0)) + (1.0 - ahead.a) * (1.0 - alpha);
        target_light = vec4(exposed_light * frame.light_scale + behind, 1.0 - background);
        return;
    }
    light_over(vec4(exposed_light * frame.light_scale, 0.0));
}
