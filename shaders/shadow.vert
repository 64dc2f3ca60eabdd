// Projection along the key light onto the floor.
layout(location = 0) in vec3 position_m;
#ifdef MASK
layout(location = 2) in vec4 vertex_colour;
layout(location = 3) in vec2 texture_coordinate;
#endif

uniform mat4 model;
uniform vec2 centre_m; // x, z
uniform float half_size_m;
uniform float floor_height_m;
uniform vec3 key_direction; // unit, towards the light

out float height_m; // above the floor
#ifdef MASK
out float base_alpha;
out vec2 base_coordinate;
#endif

void main() {
    vec4 world = model * vec4(position_m, 1.0);
    height_m = world.y - floor_height_m;
    vec2 cast_m = world.xz - height_m / key_direction.y * key_direction.xz;
    gl_Position = vec4((cast_m - centre_m) / half_size_m, 0.0, 1.0);
#ifdef MASK
    base_alpha = vertex_colour.a;
    base_coordinate = texture_coordinate;
#endif
}
