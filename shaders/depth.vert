// Depths along the light.
layout(location = 0) in vec3 position_m;
#ifdef MASK
layout(location = 2) in vec4 vertex_colour;
layout(location = 3) in vec2 texture_coordinate;
#endif

uniform mat4 model;
uniform mat4 light; // from the world to 0…1

#ifdef MASK
out float base_alpha;
out vec2 base_coordinate;
#endif

void main() {
    vec3 seen = (light * model * vec4(position_m, 1.0)).xyz;
    gl_Position = vec4(2.0 * seen - 1.0, 1.0);
#ifdef MASK
    base_alpha = vertex_colour.a;
    base_coordinate = texture_coordinate;
#endif
}
