// Vertical projection onto the floor, so that a shadow shows x and z on the grid.
layout(location = 0) in vec3 position_m;

uniform mat4 model;
uniform vec2 centre_m; // x, z
uniform float half_size_m;
uniform float floor_height_m;

out float height_m; // above the floor

void main() {
    vec4 world = model * vec4(position_m, 1.0);
    height_m = world.y - floor_height_m;
    gl_Position = vec4((world.xz - centre_m) / half_size_m, 0.0, 1.0);
}
