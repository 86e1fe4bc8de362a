// Globe maps: pictures that lights shine through. Projective texturing (Segal et al. 1992, "Fast Shadows and Lighting
// Effects Using Texture Mapping") from the light's frame; Koonce 2007, 19.4.2.

// All maps, of one size: flat ones a layer each, cubes six (+X, -X, +Y, -Y, +Z, -Z of the light's frame).
layout(set = SET_FRAME, binding = BINDING_GLOBE_MAPS) uniform sampler2DArray globe_maps;

// Maps are projected from at least this distance, metres: in front of a spot (what is nearer or behind is dark), and
// around a point light.
const float MIN_AHEAD = 1e-4;

vec2 turned(vec2 p, float angle) {
    float c = cos(angle);
    float s = sin(angle);
    return vec2(c * p.x + s * p.y, c * p.y - s * p.x);
}

// `p` from -1 to 1, y up. The level is given: neighbouring pixels may look at other lights.
vec3 globe_texel(uint layer, vec2 p) {
    return textureLod(globe_maps, vec3(0.5 + 0.5 * p.x, 0.5 - 0.5 * p.y, float(layer)), 0.0).rgb;
}

// Of a box or a spot, `position_light` in the light's frame.
vec3 globe_flat(Light light, vec3 position_light, bool is_spot) {
    vec2 p = turned(position_light.xy, light.globe_rotation);
    if (is_spot) {
        p /= max(-position_light.z, MIN_AHEAD);
    }
    return globe_texel(light.globe_map - 1u, p / light.half_size.xy);
}

// Of a point light. Faces are as a camera at the light sees them, x to the right.
vec3 globe_cube(Light light, vec3 position_light) {
    vec3 d = position_light;
    d.zx = turned(d.zx, light.globe_rotation);
    vec3 a = abs(d);
    uint face;
    vec2 p;
    if (a.x >= a.y && a.x >= a.z) {
        face = d.x < 0.0 ? 1u : 0u;
        p = vec2(d.x < 0.0 ? -d.z : d.z, d.y) / max(a.x, MIN_AHEAD);
    } else if (a.y >= a.z) {
        face = d.y < 0.0 ? 3u : 2u;
        p = vec2(d.x, d.y < 0.0 ? -d.z : d.z) / max(a.y, MIN_AHEAD);
    } else {
        face = d.z < 0.0 ? 5u : 4u;
        p = vec2(d.z < 0.0 ? d.x : -d.x, d.y) / max(a.z, MIN_AHEAD);
    }
    return globe_texel(light.globe_map - 1u + face, p);
}
