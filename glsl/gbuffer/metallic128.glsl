// Smith and Einig 2015, "Physically Based Deferred Shading on Mobile", listing 2.2:
//   depth                R32_SFLOAT            reversed depth
//   normal_roughness     R8G8B8A8_UNORM        normal * 0.5 + 0.5, roughness; all 0: not lit
//   base_color_metallic  R8G8B8A8_SRGB         base colour (the attachment encodes), metallic
//   light                A2B10G10R10_UNORM     exposed light * light_scale (geometry.frag, lighting.frag)

#include "gbuffer/surface.glsl"

#ifdef SUBPASS_GEOMETRY

layout(location = TARGET_DEPTH) out float target_depth;
layout(location = TARGET_NORMAL_ROUGHNESS) out vec4 target_normal_roughness;
layout(location = TARGET_BASE_COLOR_METALLIC) out vec4 target_base_color_metallic;

void gbuffer_write(Surface surface) {
    target_depth = surface.depth;
    target_normal_roughness =
        surface.lit ? vec4(surface.normal_world * 0.5 + 0.5, surface.roughness) : vec4(0.0);
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

    // A unit vector's encoding is never all 0: that would be (-1, -1, -1).
    bool lit = normal_roughness.xyz != vec3(0.0);
    // 8 bits do not keep the length.
    vec3 normal_world = unit(normal_roughness.xyz * 2.0 - 1.0);
    return Surface(
        depth, lit, normal_world, normal_roughness.w, base_color_metallic.rgb, base_color_metallic.a);
}

#endif
