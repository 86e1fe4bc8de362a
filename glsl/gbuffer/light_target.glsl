// The light targets as what is blended over them finds them. Wants SPLIT_LIGHT.

layout(location = TARGET_LIGHT) out vec4 target_light;
layout(location = TARGET_SPECULAR_LIGHT) out vec4 target_specular_light;

// Light that is complete, exposed * light_scale and multiplied by alpha, of which that much covers what is behind.
void light_over(vec4 light) {
    if (SPLIT_LIGHT) {
        target_light = vec4(0.0, 0.0, 0.0, light.a);
        target_specular_light = light;
    } else {
        target_light = light;
    }
}
