#version 450
// The environment where no surface is. A depth test at the far plane keeps it off surfaces; the G-buffer says that
// nothing is to be lit. Without a G-buffer it is tonemapped and written to the output.
#extension GL_GOOGLE_include_directive : require
#ifdef LIGHT_TARGET
#define SUBPASS_GEOMETRY
#endif
#include "common.glsl"
#include "frame.glsl"
#include "pixel.glsl"
#include "light/environment.glsl"

#ifdef LIGHT_TARGET
#include "gbuffer.glsl"
layout(location = TARGET_LIGHT) out vec4 target_light;
#else
#include "tonemap.glsl"
layout(location = TARGET_OUTPUT) out vec4 target_output;
#endif

void main() {
    vec3 exposed_light = environment_radiance_nt(ray_world(), 0.0) * frame.exposure;
#ifdef LIGHT_TARGET
    gbuffer_write(Surface(0.0, false, vec3(0.0), 0.0, vec3(0.0), 0.0));
    // Alpha 0: no surface, and so no fog.
    target_light = vec4(exposed_light * frame.light_scale, 0.0);
#else
    target_output = output_color(exposed_light);
#endif
}
