// Diffuse light that was computed ahead: Smith and Einig 2015, "Physically Based Deferred Shading on Mobile", listing 2.5.

layout(constant_id = ID_LIGHTMAP_UNIT) const float LIGHTMAP_UNIT = 1.0; // lux of a decoded 1

layout(set = SET_FRAME, binding = BINDING_LIGHTMAP_COLOR) uniform sampler2D lightmap_color;
layout(set = SET_FRAME, binding = BINDING_LIGHTMAP_SCALE) uniform sampler2D lightmap_scale;

layout(location = VARYING_LIGHTMAP) in vec2 varying_lightmap;

// Lux. One level, so no derivatives are needed.
vec3 lightmap_irradiance() {
    const float rgbm_range = 6.0;
    float scale = textureLod(lightmap_scale, varying_lightmap, 0.0).r;
    vec3 root = textureLod(lightmap_color, varying_lightmap, 0.0).rgb * (scale * rgbm_range);
    return root * root * LIGHTMAP_UNIT;
}
