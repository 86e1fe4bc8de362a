// Fog between a surface and the viewer; see src/reference/fog.rs.

layout(constant_id = ID_FOG) const bool FOG = false;
layout(constant_id = ID_FOG_RED) const float FOG_RED = 0.0; // cd/m^2
layout(constant_id = ID_FOG_GREEN) const float FOG_GREEN = 0.0;
layout(constant_id = ID_FOG_BLUE) const float FOG_BLUE = 0.0;
layout(constant_id = ID_FOG_DENSITY) const float FOG_DENSITY = 0.0;           // 1 / m
layout(constant_id = ID_FOG_BASE) const float FOG_BASE = 0.0;                 // m
layout(constant_id = ID_FOG_INVERSE_HEIGHT) const float FOG_INVERSE_HEIGHT = 0.0; // 1 / m; 0: alike everywhere

// The share of light that gets from one point to another: exp(-integral of density), density falling exponentially
// with height (Wenzel, "Real-time Atmospheric Effects in Games", SIGGRAPH 2006; Quilez, "Better fog", 2010).
float fog_transmittance(vec3 from_world, vec3 to_world) {
    float optical_depth = FOG_DENSITY * distance(from_world, to_world);
    if (FOG_INVERSE_HEIGHT > 0.0) {
        float a = (from_world.y - FOG_BASE) * FOG_INVERSE_HEIGHT;
        float b = (to_world.y - FOG_BASE) * FOG_INVERSE_HEIGHT;
        // (exp(-a) - exp(-b)) / (b - a): the denser end times (1 - exp(-x)) / x, which cancels where x is small.
        float x = min(abs(b - a), 1e30);
        float mean = x < 0.05 ? 1.0 - x * (0.5 - x * (1.0 / 6.0 - x / 24.0)) : (1.0 - exp(-x)) / x;
        optical_depth *= exp(-min(a, b)) * mean;
    }
    return exp(-optical_depth);
}

// Exposed light of a surface at `position_world` as it arrives at this pixel.
vec3 fogged(vec3 exposed_light, vec3 position_world) {
    vec3 color = vec3(FOG_RED, FOG_GREEN, FOG_BLUE) * frame.exposure;
    return mix(color, exposed_light, fog_transmittance(ray_origin_world(), position_world));
}
