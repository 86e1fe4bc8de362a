// Lights with an extent, and light from all around: Koonce 2007, "Deferred Shading in Tabula Rasa" (GPU Gems 3), 19.4.

// Boxes' falloff is held to at least this, metres: an edge, but no division by 0.
const float MIN_FALLOFF = 1e-4;

// In the light's frame: x right, y up, -z the way the light travels.
vec3 in_light_frame(Light light, vec3 position_world) {
    vec3 from_light = position_world - light.place.xyz;
    vec3 right_world = cross(light.direction_world, light.up_world);
    return vec3(
        dot(from_light, right_world), dot(from_light, light.up_world), -dot(from_light, light.direction_world)
    );
}

// 0 outside the box, smoothstep over the falloff inside each face, the three axes multiplied.
float box_window(vec3 position_light, vec3 half_size, float falloff) {
    vec3 widths = min(vec3(max(falloff, MIN_FALLOFF)), half_size);
    vec3 t = clamp((half_size - abs(position_light)) / widths, 0.0, 1.0);
    vec3 s = t * t * (3.0 - 2.0 * t);
    return s.x * s.y * s.z;
}

Incident light_box(Light light, vec3 position_world) {
    float window = box_window(in_light_frame(light, position_world), light.half_size, light.edge);
    return Incident(-light.direction_world, light.intensity * window, light.back_intensity * window);
}

// Irradiance of all hemisphere lights, lux. Of one it is mix(ground, sky, 0.5 + 0.5 n.up) = (sky + ground) / 2 +
// (sky - ground) / 2 n.up, which is linear in n, so that their number does not matter.
vec3 light_hemispheres(vec3 n) {
    vec4 h = vec4(n, 1.0);
    return max(vec3(dot(frame.hemispheres[0], h), dot(frame.hemispheres[1], h), dot(frame.hemispheres[2], h)), 0.0);
}
