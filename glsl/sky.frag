#version 450
// The environment where no surface is: fullscreen.vert draws at the far plane, and the depth test keeps it off surfaces.
// It goes to the light target, beside a G-buffer which says that nothing is to be lit; without either, tonemapped to the output.
#extension GL_GOOGLE_include_directive : require
#if defined(LAYOUT_METALLIC128) || defined(LAYOUT_EXACT)
#define WITH_GBUFFER
#define SUBPASS_GEOMETRY
#endif
#include "common.glsl"
#include "frame.glsl"
#include "pixel.glsl"
#include "light/environment.glsl"

#ifdef WITH_GBUFFER
#include "gbuffer.glsl"
layout(location = TARGET_LIGHT) out vec4 target_light;
#else
#include "tonemap.glsl"
layout(constant_id = ID_LIGHT_TARGET) const bool LIGHT_TARGET = false;
layout(location = TARGET_OUTPUT) out vec4 target_output;
#endif

void main() {
    vec3 exposed_light = environment_radiance_nt(ray_world(), 0.0) * frame.exposure;
    // Alpha 0: no surface, and so no fog.
    vec4 light = vec4(exposed_light * frame.light_scale, 0.0);
#ifdef WITH_GBUFFER
    gbuffer_write(Surface(0.0, false, vec3(0.0), 0.0, vec3(0.0), 0.0));
    target_light = light;
#else
    target_output = LIGHT_TARGET ? light : output_color(exposed_light);
#endif
}
