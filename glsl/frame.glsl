// The camera and everything else that one frame has once. Mirrors FrameUniforms in src/gpu/shared.rs.

layout(set = SET_FRAME, binding = BINDING_FRAME, std140) uniform Frame {
    mat4 clip_from_world;
    vec4 camera_position_world; // w: 1 perspective, 0 orthographic
    vec4 right_world;           // ndc.x = +1, at distance 1 (perspective) or in metres (orthographic)
    vec4 down_world;            // ndc.y = +1, likewise
    vec4 forward_world;         // unit length
    vec4 distance_from_depth;   // distance = (x + y * depth) / (z + w * depth)
    vec2 inverse_size;          // 1 / pixels
    float exposure;             // multiplier
    float light_scale;          // stored light = exposed light * light_scale
    vec4 ambient_nt;
    uvec4 light_counts;         // directional, point, spot, box
    vec4 hemispheres[3];        // irradiance of hemisphere lights: of channel c, lux, dot(hemispheres[c], (normal, 1))
    vec4 bloom;                 // share of light that is scattered; exposure now / when it was spread; unused
} frame;
