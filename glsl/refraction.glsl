// What is behind a surface that bends its light, as far as the picture of what is opaque shows it. Wants medium.glsl. See
// src/reference/refraction.rs. Of several samples a pixel each sees a picture of its own, of the samples at its place in all pixels.

#define SET_BEHIND SET_LAYERS
#include "backdrop.glsl"

struct Bent {
    vec3 light;      // that arrives at the surface from inside, as in the light target
    vec3 left;       // the share of light that its way has left
    vec3 background; // that of a background's colour, which is no light
};

// Where what is opaque at a pixel's centre is.
vec3 place_world(ivec2 pixel, float depth) {
    vec2 ndc = (vec2(pixel) + place_in_pixel()) * (2.0 * frame.inverse_size) - 1.0;
    vec3 offset = frame.right_world.xyz * ndc.x + frame.down_world.xyz * ndc.y;
    float perspective = frame.camera_position_world.w;
    vec3 origin = frame.camera_position_world.xyz + offset * (1.0 - perspective);
    return origin + (frame.forward_world.xyz + offset * perspective) * distance_of(depth);
}

// Light takes no longer way than the medium is thick, also from where nothing is.
float way_to(vec3 position_world, ivec2 pixel, float depth, float share) {
    float way = depth > 0.0 ? distance(position_world, place_world(pixel, depth)) * share : medium.thickness_m;
    return min(way, medium.thickness_m);
}

float depth_at(ivec2 pixel) {
    return HAS_BEHIND ? fetch_behind(behind_depth, pixel).r : 0.0;
}

void add_behind(inout Bent sum, vec3 position_world, ivec2 pixel, float depth, float weight) {
    vec4 light = fetch_behind(behind_light, pixel);
    vec3 left = exp(-medium.absorption_per_m * way_to(position_world, pixel, depth, 1.0)) * weight;
    sum.light += light.rgb * left;
    sum.left += left;
    sum.background += left * (1.0 - light.a);
}

// The ray is bent by Snell's law, goes on until it is as far below the surface as the unbent one of this pixel is where that ends, and
// what the picture shows at the end of it is taken for what it meets (KHR_materials_volume's sample viewer,
// `getVolumeTransmissionRay` and `getIBLVolumeRefraction`, goes on for the thickness). Interpolated between four pixels, without
// those that show something before the surface.
Bent bent_light(Surface surface) {
    ivec2 own = ivec2(gl_FragCoord.xy);
    float own_depth = HAS_BEHIND ? depth_behind(own_sample) : 0.0;
    vec3 position_world = surface.position_world;
    vec3 direction = refract(-view_direction_world(), surface.normal_world, medium.inverse_ior);
    float steeper = max(dot(surface.normal_world, view_direction_world()), 0.0) / max(-dot(surface.normal_world, direction), 1e-6);
    vec3 end_world = position_world + direction * way_to(position_world, own, own_depth, steeper);
    vec4 end = frame.clip_from_world * vec4(end_world, 1.0);
    ivec2 last = size_behind(behind_light) - 1;
    Bent sum = Bent(vec3(0.0), vec3(0.0), vec3(0.0));
    float weights = 0.0;
    if (end.w > 0.0) {
        vec2 place = (end.xy / end.w * 0.5 + 0.5) / frame.inverse_size - place_in_pixel();
        place = clamp(place, vec2(0.0), vec2(last));
        ivec2 first = ivec2(place);
        vec2 share = place - vec2(first);
        for (int i = 0; i < 4; ++i) {
            ivec2 corner = ivec2(i & 1, i >> 1);
            ivec2 pixel = min(first + corner, last);
            float depth = depth_at(pixel);
            vec2 near = mix(1.0 - share, share, vec2(corner));
            float weight = depth < gl_FragCoord.z ? near.x * near.y : 0.0;
            add_behind(sum, position_world, pixel, depth, weight);
            weights += weight;
        }
    }
    if (weights > 0.0) {
        return Bent(sum.light / weights, sum.left / weights, sum.background / weights);
    }
    add_behind(sum, position_world, own, own_depth, 1.0);
    return sum;
}
