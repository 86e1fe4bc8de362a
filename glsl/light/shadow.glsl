// How much of a light gets past what stands in its way.

layout(constant_id = ID_SHADOW_FILTER) const uint SHADOW_FILTER = SHADOW_FILTER_GRID3;

// A tile of the shadow map. Mirrors ShadowViewData in src/gpu/shared.rs.
struct ShadowView {
    mat4 map_from_world; // homogeneous: xy of the whole map, 0 to 1; reversed depth
    vec4 tile;           // least and greatest xy that samples may have: the outermost texels' centres
    float texel_m;       // width of a texel at w = 1
    float spread_texels; // the filter's radius
    float offset_texels; // how far receivers are moved along their normal at grazing light
    float lift_texels;   // and towards the light
};

layout(set = SET_FRAME, binding = BINDING_SHADOW_VIEWS, std430) readonly buffer ShadowViews {
    ShadowView list[];
} shadow_views;

// Compares: 1 where the receiver is at least as near to the light as what the map holds.
layout(set = SET_FRAME, binding = BINDING_SHADOW_MAP) uniform sampler2DShadow shadow_map;

// What a light has of the map: Light.shadow is the first view + 1 and, 16 bits up, the number of views; 0: no shadow.
const uint SHADOW_COUNT_SHIFT = 16u;
const uint SHADOW_FACES = 6u;

// The hardware compares the four texels around `at` and interpolates the results.
float shadow_sample(ShadowView view, vec2 at, float depth) {
    return textureLod(shadow_map, vec3(clamp(at, view.tile.xy, view.tile.zw), depth), 0.0);
}

// n x n samples over the square of the filter's radius.
float shadow_grid(ShadowView view, vec2 at, vec2 radius, float depth, int n) {
    float lit = 0.0;
    for (int y = 0; y < n; ++y) {
        for (int x = 0; x < n; ++x) {
            vec2 offset = vec2(x, y) * (2.0 / float(n - 1)) - 1.0;
            lit += shadow_sample(view, at + offset * radius, depth);
        }
    }
    return lit / float(n * n);
}

// The same for all samples of a pixel.
vec2 noise_place() {
#ifdef MULTISAMPLED
    return floor(gl_FragCoord.xy) + 0.5;
#else
    return gl_FragCoord.xy;
#endif
}

// Samples on a disc along Vogel's spiral (Vogel 1979, "A better way to construct the sunflower head"), turned by another
// angle in each pixel: interleaved gradient noise (Jimenez 2014, "Next Generation Post Processing in Call of Duty: Advanced
// Warfare"), whose 3x3 neighbours have all different values. The same pixel always has the same.
float shadow_jittered(ShadowView view, vec2 at, vec2 radius, float depth) {
    const int SAMPLES = 12;
    const float GOLDEN_ANGLE = 2.39996322972865332;
    float noise = fract(52.9829189 * fract(dot(noise_place(), vec2(0.06711056, 0.00583715))));
    float lit = 0.0;
    for (int i = 0; i < SAMPLES; ++i) {
        float angle = GOLDEN_ANGLE * float(i) + 2.0 * PI * noise;
        float distance = sqrt((float(i) + 0.5) / float(SAMPLES));
        lit += shadow_sample(view, at + vec2(cos(angle), sin(angle)) * (distance * radius), depth);
    }
    return lit / float(SAMPLES);
}

// `p` is the receiver's place in the map, homogeneous.
float shadow_filtered(ShadowView view, vec4 p) {
    vec2 at = p.xy / p.w;
    // Cleared texels hold 0: nothing beyond the far plane is in shadow.
    float depth = max(p.z / p.w, 0.0);
    vec2 radius = view.spread_texels / vec2(textureSize(shadow_map, 0));
    switch (SHADOW_FILTER) {
        case SHADOW_FILTER_HARDWARE: return shadow_sample(view, at, depth);
        case SHADOW_FILTER_GRID5: return shadow_grid(view, at, radius, depth, 5);
        case SHADOW_FILTER_JITTERED: return shadow_jittered(view, at, radius, depth);
        default: return shadow_grid(view, at, radius, depth, 3);
    }
}

// Where a receiver is compared, so that it does not shadow itself. A texel holds one depth for all places that fall into
// it, and a filter compares with texels up to R away: on a plane at an angle theta to the light they are nearer to the light
// by up to R * tan(theta). Moving the receiver by d along its normal brings it d / cos(theta) nearer, so that
// d = R * sin(theta) is just enough at every angle (Holbert 2011, "Saying Goodbye to Shadow Acne", GDC poster). In a
// perspective view theta is the angle to the view's axis, along which depths are compared: with p = w (u a + v b + axis), a
// plane n . p = k has dw/du = -w (n . a) / (n . p / w), and moving it by d changes w by d / (n . p / w). What is moved towards
// the light covers rounding where theta is 0.
//
// That is for a plane and for edges that fall away from the light. Where another surface rises towards the light from an edge
// beside the receiver, it is nearer by its own slope times the distance: casters are pushed by that (ShadowView in
// src/visible).
vec3 shadow_receiver(ShadowView view, float texel_m, vec3 axis, vec3 position, vec3 normal, vec3 to_light) {
    float cosine = dot(normal, axis);
    float sine = sqrt(max(1.0 - cosine * cosine, 0.0));
    return position + (normal * (view.offset_texels * sine) + to_light * view.lift_texels) * texel_m;
}

// The distance from the light along the view's axis; its xyz is the axis, or 0 for parallel views, whose w is 1.
vec4 shadow_row_w(ShadowView view) {
    mat4 m = view.map_from_world;
    return vec4(m[0].w, m[1].w, m[2].w, m[3].w);
}

// The face of the cube around a light in which a direction lies: +X, -X, +Y, -Y, +Z, -Z.
uint shadow_face(vec3 from_light) {
    vec3 size = abs(from_light);
    uint face = size.x >= size.y && size.x >= size.z ? 0u : size.y >= size.z ? 2u : 4u;
    float side = face == 0u ? from_light.x : face == 2u ? from_light.y : from_light.z;
    return face + (side < 0.0 ? 1u : 0u);
}

// The receiver's place in a view's map, homogeneous.
vec4 shadow_place(ShadowView view, vec3 position, vec3 normal, vec3 to_light) {
    vec4 row_w = shadow_row_w(view);
    float texel_m = view.texel_m * dot(row_w, vec4(position, 1.0));
    vec3 axis = row_w.xyz == vec3(0.0) ? to_light : row_w.xyz;
    vec3 receiver = shadow_receiver(view, texel_m, axis, position, normal, to_light);
    return view.map_from_world * vec4(receiver, 1.0);
}

// 0 in shadow to 1 in full light, for a light with a shadow. All in world space; `to_light` has unit length.
float shadow(uint light_shadow, vec3 light_position, vec3 position, vec3 normal, vec3 to_light) {
    uint first = (light_shadow & ((1u << SHADOW_COUNT_SHIFT) - 1u)) - 1u;
    uint count = light_shadow >> SHADOW_COUNT_SHIFT;
    if (count == SHADOW_FACES) {
        // Where the moved receiver is on another face, it is within this one's guard: another face's axis would have asked
        // for another offset.
        ShadowView view = shadow_views.list[first + shadow_face(position - light_position)];
        return shadow_filtered(view, shadow_place(view, position, normal, to_light));
    }
    // The finest view that holds the place and what filters read around it; a light of one view shines within it only.
    for (uint i = first; i < first + count; ++i) {
        ShadowView view = shadow_views.list[i];
        vec4 p = shadow_place(view, position, normal, to_light);
        vec2 reach = (view.spread_texels + 1.0) / vec2(textureSize(shadow_map, 0));
        bool inside = p.w > 0.0 && all(greaterThan(p.xy, (view.tile.xy + reach) * p.w))
            && all(lessThan(p.xy, (view.tile.zw - reach) * p.w));
        if (inside) {
            return shadow_filtered(view, p);
        }
    }
    return 1.0;
}
