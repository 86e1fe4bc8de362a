// What a material says at a fragment. Which textures exist, and where, are specialisation constants: a pipeline
// samples what its material has and carries as many descriptors.

#ifndef MATERIAL_SET
#define MATERIAL_SET SET_MATERIAL
// How a texture is looked up.
#define MATERIAL_TEXTURE(SAMPLER, KIND) texture(SAMPLER, material_uv(KIND))
#endif

layout(constant_id = ID_ALPHA_MASK) const bool ALPHA_MASK = false;
layout(constant_id = ID_VERTEX_COLOR) const bool VERTEX_COLOR = false;

// Mirrors MaterialData in src/gpu/shared.rs. Uniforms rather than an element of a storage buffer: the address is the same
// for the whole draw, so GPUs keep it in registers, and drivers that skip masked-off lanes' loads (lavapipe 22) cannot
// spoil the derivatives of transformed texture coordinates.
layout(set = MATERIAL_SET, binding = BINDING_MATERIAL, std140) uniform Material {
    vec4 base_color_factor;
    vec4 emissive_factor_alpha_cutoff;
    float metallic_factor;
    float roughness_factor;
    float normal_scale;
    float occlusion_strength;
    vec4 uv_rows[KIND_COUNT][2]; // uv = (dot(row 0, (s, t, 1)), dot(row 1, (s, t, 1)))
} material;

layout(location = VARYING_COLOR) in vec4 varying_color;

layout(constant_id = ID_TEXTURE_COUNT) const uint TEXTURE_COUNT = 1;
layout(constant_id = ID_SLOT_BASE_COLOR) const int SLOT_BASE_COLOR = -1;
layout(constant_id = ID_SLOT_METALLIC_ROUGHNESS) const int SLOT_METALLIC_ROUGHNESS = -1;
layout(constant_id = ID_SLOT_NORMAL) const int SLOT_NORMAL = -1;
layout(constant_id = ID_SLOT_OCCLUSION) const int SLOT_OCCLUSION = -1;
layout(constant_id = ID_SLOT_EMISSIVE) const int SLOT_EMISSIVE = -1;
layout(constant_id = ID_TEXCOORD_BITS) const uint TEXCOORD_BITS = 0;
layout(constant_id = ID_TRANSFORM_BITS) const uint TRANSFORM_BITS = 0;

layout(set = MATERIAL_SET, binding = BINDING_TEXTURES) uniform sampler2D material_textures[TEXTURE_COUNT];
layout(location = VARYING_TEXCOORD) in vec4 varying_texcoord; // xy TEXCOORD_0, zw TEXCOORD_1

vec2 material_uv(int kind) {
    vec2 uv = (TEXCOORD_BITS >> kind & 1u) != 0u ? varying_texcoord.zw : varying_texcoord.xy;
    if ((TRANSFORM_BITS >> kind & 1u) != 0u) {
        vec3 h = vec3(uv, 1.0);
        uv = vec2(dot(material.uv_rows[kind][0].xyz, h), dot(material.uv_rows[kind][1].xyz, h));
    }
    return uv;
}

// A macro, so that the array index is a constant expression: no device feature for dynamic indexing is needed.
// Samples come before any discard, where derivatives are still defined.
#define MATERIAL_SAMPLE(NAME, ABSENT) \
    (SLOT_##NAME < 0 ? (ABSENT) : MATERIAL_TEXTURE(material_textures[SLOT_##NAME < 0 ? 0 : SLOT_##NAME], KIND_##NAME))

// Linear Rec.709 and alpha: factor * texture * vertex colour (glTF 2.0, 3.9.2).
vec4 material_base_color() {
    vec4 color = material.base_color_factor * MATERIAL_SAMPLE(BASE_COLOR, vec4(1.0));
    return VERTEX_COLOR ? color * varying_color : color;
}

// Where devices sample a pixel, relative to its centre (Vulkan specification, "Standard sample locations"): 2, 4 and 8 samples.
const vec2 SAMPLE_PLACES[14] = vec2[](
    vec2(4, 4) / 16.0, vec2(-4, -4) / 16.0,
    vec2(-2, -6) / 16.0, vec2(6, -2) / 16.0, vec2(-6, 2) / 16.0, vec2(2, 6) / 16.0,
    vec2(1, -3) / 16.0, vec2(-1, 3) / 16.0, vec2(5, 1) / 16.0, vec2(-3, -5) / 16.0,
    vec2(-5, 5) / 16.0, vec2(-7, -1) / 16.0, vec2(3, 7) / 16.0, vec2(7, -7) / 16.0);

// True where an alpha mask cuts the surface away (3.9.4). Of several samples those are left whose alpha, as far as its gradient tells,
// reaches the cutoff: the mask's outline covers a pixel as a triangle's does. (Alpha to coverage by fixed function takes the alpha of
// the first colour output, which in a G-buffer is something else.) Called where derivatives are defined.
bool material_is_cut(float alpha) {
    if (!ALPHA_MASK) {
        return false;
    }
    float above = alpha - material.emissive_factor_alpha_cutoff.w;
    if (SAMPLE_COUNT == 1) {
        return above < 0.0;
    }
    vec2 gradient = vec2(dFdx(alpha), dFdy(alpha));
    int mask = 0;
    for (int i = 0; i < SAMPLE_COUNT; ++i) {
        vec2 place = SAMPLE_PLACES[SAMPLE_COUNT - 2 + i];
        mask |= above + dot(gradient, place) < 0.0 ? 0 : 1 << i;
    }
    gl_SampleMask[0] = mask;
    return mask == 0;
}
