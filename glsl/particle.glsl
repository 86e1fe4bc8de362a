// A square that faces the camera and adds light. Mirrors ParticleData in src/gpu/shared.rs.

struct Particle {
    vec3 center_world;
    float inverse_soft; // 1 / m
    vec3 color;         // of the material's emission
    float padding;
    vec2 half_axis;     // of the square's own x on the image, right and up, metres
    vec2 padding_2;
};
