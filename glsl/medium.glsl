// What fills the space behind a surface that light goes through. Mirrors MediumData in src/gpu/shared.rs. Wants material.glsl,
// pixel.glsl and behind.glsl.

layout(set = SET_MATERIAL, binding = BINDING_MEDIUM, std140) uniform Medium {
    vec3 absorption_per_m;
    float thickness_m; // the longest way
    float factor;      // of light that enters: what is not scattered back
    float f0;          // reflectance at normal incidence
    float inverse_ior;
    float padding;
} medium;

// Beer and Lambert: what is left of light after its way along the view ray, which is at most `thickness_m`.
vec3 left_after(float distance) {
    return exp(-medium.absorption_per_m * min(distance * length(ray_world()), medium.thickness_m));
}

// From the fragment to what is opaque behind it, the mean over the samples that it is in front of.
vec3 left_behind() {
    if (!HAS_BEHIND) {
        return exp(-medium.absorption_per_m * medium.thickness_m);
    }
    float here = distance_of(gl_FragCoord.z);
    vec3 sum = vec3(0.0);
    float before = 0.0;
    for (int i = 0; i < SAMPLE_COUNT; ++i) {
        float behind = depth_behind(i);
        if (behind < gl_FragCoord.z) {
            sum += left_after(distance_of(behind) - here);
            before += 1.0;
        }
    }
    return sum / max(before, 1.0);
}

// The share of light that passes the surface: what enters (Schlick 1994).
vec3 surface_tint(Fragment fragment) {
    float n_dot_v = clamp(dot(fragment.surface.normal_world, view_direction_world()), 0.0, 1.0);
    float grazing = 1.0 - n_dot_v;
    float grazing2 = grazing * grazing;
    float entered = (1.0 - medium.f0) * (1.0 - grazing2 * grazing2 * grazing);
    return fragment.base_color * (medium.factor * (1.0 - fragment.metallic) * entered);
}

// What arrives of light behind a fragment: where alpha has no surface all does.
vec3 let_through(Fragment fragment, float alpha) {
    return surface_tint(fragment) * left_behind() * alpha + (1.0 - alpha);
}
