#version 450
// Places a caster in a tile of the shadow map. Only alpha masks read more than its position.
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"

// Mirrors InstanceData in src/gpu/shared.rs.
struct Instance {
    vec4 world_from_object_rows[3];
};

layout(set = SET_FRAME, binding = BINDING_INSTANCES, std430) readonly buffer Instances {
    Instance instances[];
};

// Mirrors ShadowPush in src/gpu/shared.rs.
layout(push_constant, std430) uniform ShadowPush {
    mat4 clip_from_world;
    float nearest_depth; // of parallel views: what is nearer to the light is drawn at this depth
} push;

layout(location = ATTRIBUTE_POSITION) in vec3 attribute_position;
layout(location = ATTRIBUTE_TEXCOORD) in vec4 attribute_texcoord;
layout(location = ATTRIBUTE_COLOR) in vec4 attribute_color;

layout(location = VARYING_TEXCOORD) out vec4 varying_texcoord;
layout(location = VARYING_COLOR) out vec4 varying_color;

out gl_PerVertex {
    vec4 gl_Position;
};

void main() {
    vec4 position = vec4(attribute_position, 1.0);
    vec4 rows[3] = instances[gl_InstanceIndex].world_from_object_rows;
    vec4 position_world = vec4(dot(rows[0], position), dot(rows[1], position), dot(rows[2], position), 1.0);
    gl_Position = push.clip_from_world * position_world;
    // Not so behind a lamp: a clamped vertex there would have most of its triangle clipped.
    gl_Position.z = min(gl_Position.z, push.nearest_depth);

    varying_texcoord = attribute_texcoord;
    varying_color = attribute_color;
}
