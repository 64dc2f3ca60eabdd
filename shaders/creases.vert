// The creases of the scene's meshes, as dark lines.
layout(location = 0) in vec3 position_m;

uniform mat4 view_projection;
uniform vec3 eye_m;

out vec4 own_colour;

const float kNearer = 0.002; // of the way to the eye: before the triangles that meet there

void main() {
    own_colour = vec4(0.0, 0.0, 0.0, 1.0);
    gl_Position = view_projection * vec4(mix(position_m, eye_m, kNearer), 1.0);
}
