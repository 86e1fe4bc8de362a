// Diffuse light that was computed ahead: Smith and Einig 2015, "Physically Based Deferred Shading on Mobile", listing 2.5.

layout(constant_id = ID_LIGHTMAP_UNIT) const float LIGHTMAP_UNIT = 1.0; // lux of a decoded 1

layout(constant_id = ID_LIGHTMAP_RGBM) const bool LIGHTMAP_RGBM = false;

layout(set = SET_FRAME, binding = BINDING_LIGHTMAP) uniform sampler2D lightmap;

layout(location = VARYING_LIGHTMAP) in vec2 varying_lightmap;

// Lux. One level, so no derivatives are needed.
vec3 lightmap_irradiance() {
    const float rgbm_range = 6.0;
    vec4 stored = textureLod(lightmap, varying_lightmap, 0.0);
    vec3 root = stored.rgb * (stored.a * rgbm_range);
    return (LIGHTMAP_RGBM ? root * root : stored.rgb) * LIGHTMAP_UNIT;
}
