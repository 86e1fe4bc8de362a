#version 450
// Writes the light that leaves a surface without light sources to the light target; they are added one by one (light.frag).
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "frame.glsl"
#include "pixel.glsl"
#include "gbuffer/surface.glsl"
#include "brdf.glsl"
#include "fragment.glsl"

layout(location = TARGET_OUTPUT) out vec4 target_output;

void main() {
    target_output = vec4(indirect_light(surface_at_fragment()) * (frame.exposure * frame.light_scale), 1.0);
}
