#version 450
// The square of each particle, across the view axis: all of it is as far away as its centre.
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "frame.glsl"
#include "particle.glsl"

layout(set = SET_FRAME, binding = BINDING_PARTICLES, std430) readonly buffer Particles {
    Particle particles[];
};

layout(location = VARYING_TEXCOORD) out vec4 varying_texcoord;
layout(location = VARYING_PARTICLE) flat out vec4 varying_particle; // colour, 1 / the soft distance

void main() {
    const vec2 corners[6] = vec2[](vec2(-1, -1), vec2(1, -1), vec2(1, 1), vec2(-1, -1), vec2(1, 1), vec2(-1, 1));
    Particle particle = particles[gl_InstanceIndex];
    vec2 corner = corners[gl_VertexIndex];
    vec2 x = particle.half_axis;
    vec2 offset = x * corner.x + vec2(-x.y, x.x) * corner.y;
    vec3 offset_world = unit(frame.right_world.xyz) * offset.x - unit(frame.down_world.xyz) * offset.y;
    varying_texcoord = vec4(0.5 + 0.5 * corner.x, 0.5 - 0.5 * corner.y, 0.0, 0.0);
    varying_particle = vec4(particle.color, particle.inverse_soft);
    gl_Position = frame.clip_from_world * vec4(particle.center_world + offset_world, 1.0);
}
