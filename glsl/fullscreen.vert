#version 450
// One triangle over the whole image: no diagonal along which fragments would be shaded twice.

out gl_PerVertex {
    vec4 gl_Position;
};

void main() {
    // (-1, -1), (3, -1), (-1, 3)
    vec2 corner = vec2(gl_VertexIndex & 1, gl_VertexIndex >> 1);
    gl_Position = vec4(corner * 4.0 - 1.0, 0.0, 1.0);
}
