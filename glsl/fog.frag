#version 450
// Lays fog over the surfaces of the G-buffer: fullscreen.vert draws at the far plane, and the depth test leaves out where there is
// none.
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "frame.glsl"
#include "pixel.glsl"
#include "gbuffer.glsl"
#include "gbuffer/light_target.glsl"
#include "fog.glsl"

void main() {
#ifdef MULTISAMPLED
    input_sample = PER_SAMPLE ? gl_SampleID : 0;
#endif
    float fogged = 1.0 - fog_transmittance(ray_origin_world(), gbuffer_read().position_world);
    vec3 color = vec3(FOG_RED, FOG_GREEN, FOG_BLUE) * (frame.exposure * frame.light_scale);
    light_over(vec4(color * fogged, fogged));
}
