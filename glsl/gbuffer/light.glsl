// Light before the tone curve: exposed light * light_scale, alpha 1 where a surface is.

layout(constant_id = ID_LIGHT_TARGET) const bool LIGHT_TARGET = false; // summed in a target, which later stages add to
layout(constant_id = ID_LIGHT_READ) const bool LIGHT_READ = false;     // in the G-buffer: read once, never added to

#ifdef SUBPASS_GEOMETRY

layout(location = TARGET_LIGHT) out vec4 target_light;
layout(location = TARGET_SPECULAR_LIGHT) out vec4 target_specular_light;

// Light that is complete: no albedo is to be applied to it.
void light_write(vec4 light) {
    if (SPLIT_LIGHT) {
        target_light = vec4(0.0);
        target_specular_light = light;
    } else {
        target_light = light;
    }
}

#endif
