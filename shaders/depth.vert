// Depths along the light.
layout(location = 0) in vec3 position_m;

uniform mat4 model;
uniform mat4 light; // from the world to 0…1

void main() {
    vec3 seen = (light * model * vec4(position_m, 1.0)).xyz;
    gl_Position = vec4(2.0 * seen - 1.0, 1.0);
}
