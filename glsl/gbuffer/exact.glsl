// Every channel a 32-bit float, so that what is left of an error is the shaders':
//   depth                R32_SFLOAT            reversed depth
//   normal_roughness     R32G32B32A32_SFLOAT   normal, roughness; all 0: not lit
//   base_color_metallic  R32G32B32A32_SFLOAT   base colour, metallic
//   light                R32G32B32A32_SFLOAT   exposed light * light_scale (geometry.frag, lighting.frag)

#include "gbuffer/surface.glsl"

#ifdef SUBPASS_GEOMETRY

layout(location = TARGET_DEPTH) out float target_depth;
layout(location = TARGET_NORMAL_ROUGHNESS) out vec4 target_normal_roughness;
layout(location = TARGET_BASE_COLOR_METALLIC) out vec4 target_base_color_metallic;

void gbuffer_write(Surface surface) {
    target_depth = surface.depth;
    target_normal_roughness = surface.lit ? vec4(surface.normal_world, surface.roughness) : vec4(0.0);
    target_base_color_metallic = vec4(surface.base_color, surface.metallic);
}

#else

layout(set = SET_INPUTS, binding = INPUT_DEPTH, input_attachment_index = INPUT_DEPTH)
    uniform subpassInput input_depth;
layout(set = SET_INPUTS, binding = INPUT_NORMAL_ROUGHNESS, input_attachment_index = INPUT_NORMAL_ROUGHNESS)
    uniform subpassInput input_normal_roughness;
layout(set = SET_INPUTS, binding = INPUT_BASE_COLOR_METALLIC, input_attachment_index = INPUT_BASE_COLOR_METALLIC)
    uniform subpassInput input_base_color_metallic;

Surface gbuffer_read() {
    float depth = subpassLoad(input_depth).r;
    vec4 normal_roughness = subpassLoad(input_normal_roughness);
    vec4 base_color_metallic = subpassLoad(input_base_color_metallic);

    bool lit = normal_roughness.xyz != vec3(0.0);
    return Surface(
        depth, lit, normal_roughness.xyz, normal_roughness.w, base_color_metallic.rgb, base_color_metallic.a);
}

#endif
