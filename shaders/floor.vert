// A square of floor; needs no vertex data.
uniform mat4 view_projection;
uniform vec2 centre_m; // x, z
uniform float half_size_m;
uniform float height_m;

out vec2 world_xz_m;

void main() {
    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0;
    world_xz_m = centre_m + half_size_m * corner;
    gl_Position = view_projection * vec4(world_xz_m.x, height_m, world_xz_m.y, 1.0);
}
