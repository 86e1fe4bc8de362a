#version 450
// The environment where no surface is: fullscreen.vert draws at the far plane, and the depth test keeps it off surfaces.
// It goes where light goes, beside a G-buffer which says that nothing is to be lit; without light target, tonemapped to the
// output.
#extension GL_GOOGLE_include_directive : require
#define SUBPASS_GEOMETRY
#include "common.glsl"
#include "frame.glsl"
#include "pixel.glsl"
#include "gbuffer.glsl"
#include "light/environment.glsl"
#include "tonemap.glsl"

layout(constant_id = ID_GBUFFER) const bool GBUFFER = false;

layout(location = TARGET_OUTPUT) out vec4 target_output;

void main() {
    vec3 exposed_light = environment_radiance_nt(ray_world(), 0.0) * frame.exposure;
    // Alpha 0: no surface, and so no fog.
    vec4 light = vec4(exposed_light * frame.light_scale, 0.0);
    if (GBUFFER) {
        write_edge(false);
        write_occlusion(1.0);
        gbuffer_write(Surface(vec3(0.0), false, vec3(0.0), 0.0, vec3(0.0), vec3(0.0)), vec3(0.0), 0.0, light);
    }
    if (LIGHT_TARGET) {
        light_write(light);
    }
    if (!GBUFFER && !LIGHT_TARGET) {
        target_output = output_color(exposed_light);
    }
}
