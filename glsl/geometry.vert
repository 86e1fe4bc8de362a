#version 450
// Places a mesh in the world. HAS_*: the mesh's attributes; varyings that fragments read whatever the mesh has are
// written as constants instead.
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

#ifdef LIGHTMAP
// The instance's part of the lightmap: where TEXCOORD_1 = (0, 0) lies, and from there to (1, 1).
layout(set = SET_FRAME, binding = BINDING_LIGHTMAPS, std430) readonly buffer Lightmaps {
    vec4 lightmaps[];
};
#endif

layout(location = ATTRIBUTE_POSITION) in vec3 attribute_position;
#ifdef HAS_NORMAL
layout(location = ATTRIBUTE_NORMAL) in vec3 attribute_normal;
#endif
#ifdef HAS_TEXCOORD
layout(location = ATTRIBUTE_TEXCOORD) in vec4 attribute_texcoord;
#endif
#ifdef HAS_TANGENT
layout(location = ATTRIBUTE_TANGENT) in vec4 attribute_tangent;
#endif
#ifdef HAS_COLOR
layout(location = ATTRIBUTE_COLOR) in vec4 attribute_color;
#endif

layout(location = VARYING_NORMAL) out vec3 varying_normal_world;
#ifdef HAS_TEXCOORD
layout(location = VARYING_TEXCOORD) out vec4 varying_texcoord;
layout(location = VARYING_TANGENT) out vec4 varying_tangent_world;
#endif
layout(location = VARYING_COLOR) out vec4 varying_color;
#ifdef LIGHTMAP
layout(location = VARYING_LIGHTMAP) out vec2 varying_lightmap;
#endif

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

#ifdef HAS_NORMAL
    // Normals go by the inverse transpose, which is the cofactor matrix up to the determinant: its size is
    // normalised away, its sign is not. No inverse, so flattened objects keep their normal.
    vec3 cofactor0 = cross(row1.xyz, row2.xyz);
    vec3 cofactor1 = cross(row2.xyz, row0.xyz);
    vec3 cofactor2 = cross(row0.xyz, row1.xyz);
    float handedness = dot(row0.xyz, cofactor0) < 0.0 ? -1.0 : 1.0;
    vec3 normal_world = vec3(
        dot(cofactor0, attribute_normal), dot(cofactor1, attribute_normal), dot(cofactor2, attribute_normal));
    varying_normal_world = unit(normal_world * handedness);
#else
    varying_normal_world = vec3(0.0, 0.0, 1.0);
#endif

#ifdef HAS_TEXCOORD
    varying_texcoord = attribute_texcoord;
#ifdef HAS_TANGENT
    vec3 tangent_world = vec3(
        dot(row0.xyz, attribute_tangent.xyz), dot(row1.xyz, attribute_tangent.xyz),
        dot(row2.xyz, attribute_tangent.xyz));
    // The bitangent is cross(normal, tangent) * w in object space; a mirroring transform turns it round.
    varying_tangent_world = vec4(unit(tangent_world), attribute_tangent.w * handedness);
#else
    varying_tangent_world = vec4(1.0, 0.0, 0.0, 1.0);
#endif
#endif

#ifdef HAS_COLOR
    varying_color = attribute_color;
#else
    varying_color = vec4(1.0);
#endif

#ifdef LIGHTMAP
    vec4 rect = lightmaps[gl_InstanceIndex];
    varying_lightmap = rect.xy + attribute_texcoord.zw * rect.zw;
#endif
}
