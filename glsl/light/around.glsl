// What surfaces receive from all around: ambient light, an environment, probes. Wants pixel.glsl, brdf.glsl and Surface.

#include "light/diffuse.glsl"
#include "light/ambient.glsl"
#include "light/environment.glsl"
#include "light/probes.glsl"

layout(constant_id = ID_AMBIENT) const bool AMBIENT = false;
layout(constant_id = ID_ENVIRONMENT) const bool ENVIRONMENT = false; // besides AMBIENT

// What is reflected of it towards `v`, cd/m^2; only its mirrored part where diffuse light is known better.
vec3 reflected_around(Surface surface, vec3 v, float n_dot_v, float occlusion, bool with_diffuse) {
    vec3 diffuse_nt = frame.ambient_nt.rgb;
    vec3 specular_nt = frame.ambient_nt.rgb;
    if (ENVIRONMENT) {
        diffuse_nt += environment_irradiance_nt(surface.normal_world);
        vec3 towards = dominant_direction(surface.normal_world, v, surface.roughness);
        if (PROBES) {
            specular_nt = specular_radiance_nt(surface.position_world, towards, surface.roughness, specular_nt);
        } else {
            specular_nt += environment_radiance_nt(towards, surface.roughness);
        }
    }
    if (!with_diffuse) {
        diffuse_nt = vec3(0.0);
    }
    return light_around(surface, n_dot_v, diffuse_nt, specular_nt, occlusion);
}
