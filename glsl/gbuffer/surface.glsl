// What shading knows of a surface. The G-buffer's forms decide what is kept of it and how; only they know channels.

struct Surface {
    vec3 position_world;
    bool lit;          // false: background, or a surface whose light is complete already
    vec3 normal_world; // unit length, towards the viewer's side
    float roughness;   // perceptual
    vec3 diffuse;      // albedo under a dielectric's coat, linear Rec.709: 0 of a metal
    vec3 f0;           // reflectance at normal incidence
};

// Reflectance at normal incidence of a dielectric with index of refraction 1.5 (glTF 2.0, B.2.1).
const float DIELECTRIC_F0 = 0.04;

// Metallicness mixes a dielectric and a metal (glTF 2.0, B.2), whose terms are linear in these two colours.
vec3 diffuse_of(vec3 base_color, float metallic) {
    return base_color * (1.0 - metallic);
}

vec3 f0_of(vec3 base_color, float metallic) {
    return mix(vec3(DIELECTRIC_F0), base_color, metallic);
}

// Whether geometry leaves to lighting how much light from all around arrives.
layout(constant_id = ID_OCCLUSION_TARGET) const bool OCCLUSION_TARGET = false;
