#version 450
// Places a mesh in the world. What fragments do not read is removed when a pipeline is made, and so are its attributes.
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
#include "frame.glsl"

// Mirrors InstanceData in src/gpu/shared.rs.
struct Instance {
    vec4 world_from_object_rows[3];
};

layout(set = SET_FRAME, binding = BINDING_INSTANCES, std430) readonly buffer Instances {
    Instance instances[];
};

// The instance's part of the lightmap: where TEXCOORD_1 = (0, 0) lies, and from there to (1, 1).
layout(set = SET_FRAME, binding = BINDING_LIGHTMAPS, std430) readonly buffer Lightmaps {
    vec4 lightmaps[];
};

layout(location = ATTRIBUTE_POSITION) in vec3 attribute_position;
layout(location = ATTRIBUTE_NORMAL) in vec3 attribute_normal;
layout(location = ATTRIBUTE_TEXCOORD) in vec4 attribute_texcoord;
layout(location = ATTRIBUTE_TANGENT) in vec4 attribute_tangent;
layout(location = ATTRIBUTE_COLOR) in vec4 attribute_color;

layout(location = VARYING_NORMAL) out vec3 varying_normal_world;
layout(location = VARYING_TEXCOORD) out vec4 varying_texcoord;
layout(location = VARYING_TANGENT) out vec4 varying_tangent_world;
layout(location = VARYING_COLOR) out vec4 varying_color;
layout(location = VARYING_LIGHTMAP) out vec2 varying_lightmap;

// Equal positions give equal depths in every module, so that passes may repeat each other's geometry.
out gl_PerVertex {
    invariant vec4 gl_Position;
};

void main() {
    vec4 row0 = instances[gl_InstanceIndex].world_from_object_rows[0];
    vec4 row1 = instances[gl_InstanceIndex].world_from_object_rows[1];
    vec4 row2 = instances[gl_InstanceIndex].world_from_object_rows[2];

    vec4 position = vec4(attribute_position, 1.0);
    vec3 position_world = vec3(dot(row0, position), dot(row1, position), dot(row2, position));
    gl_Position = frame.clip_from_world * vec4(position_world, 1.0);

    // Normals go by the inverse transpose, which is the cofactor matrix up to the determinant: its size is
    // normalised away, its sign is not. No inverse, so flattened objects keep their normal.
    vec3 cofactor0 = cross(row1.xyz, row2.xyz);
    vec3 cofactor1 = cross(row2.xyz, row0.xyz);
    vec3 cofactor2 = cross(row0.xyz, row1.xyz);
    float handedness = dot(row0.xyz, cofactor0) < 0.0 ? -1.0 : 1.0;
    vec3 normal_world = vec3(
        dot(cofactor0, attribute_normal), dot(cofactor1, attribute_normal), dot(cofactor2, attribute_normal));
    varying_normal_world = unit(normal_world * handedness);

    vec3 tangent_world = vec3(
        dot(row0.xyz, attribute_tangent.xyz), dot(row1.xyz, attribute_tangent.xyz),
        dot(row2.xyz, attribute_tangent.xyz));
    // The bitangent is cross(normal, tangent) * w in object space; a mirroring transform turns it round.
    varying_tangent_world = vec4(unit(tangent_world), attribute_tangent.w * handedness);

    varying_texcoord = attribute_texcoord;
    varying_color = attribute_color;

    vec4 rect = lightmaps[gl_InstanceIndex];
    varying_lightmap = rect.xy + attribute_texcoord.zw * rect.zw;
}
