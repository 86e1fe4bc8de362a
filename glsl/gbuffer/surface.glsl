// What the G-buffer keeps of a surface. Layouts (metallic128.glsl, exact.glsl) decide how; only they know channels.

struct Surface {
    float depth;       // reversed: 1 near, 0 far
    bool lit;          // false: background, or a surface whose light is complete already
    vec3 normal_world; // unit length, towards the viewer's side
    float roughness;   // perceptual
    vec3 base_color;   // linear Rec.709
    float metallic;
};
