// One triangle that covers the viewport; needs no vertex data.
out vec2 screen; // 0 to 1, from the bottom left

void main() {
    screen = vec2((gl_VertexID & 1) * 2, (gl_VertexID >> 1) * 2);
    gl_Position = vec4(2.0 * screen - 1.0, 0.0, 1.0);
}
