// Marks in colours of their own, without light.
layout(location = 0) in vec3 position_m;
layout(location = 1) in vec4 colour; // sRGB, straight alpha

uniform mat4 view_projection;

out vec4 own_colour;

void main() {
    own_colour = colour;
    gl_Position = view_projection * vec4(position_m, 1.0);
}
