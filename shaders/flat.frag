in vec4 own_colour;

uniform float opacity;

out vec4 pixel;

void main() { pixel = vec4(own_colour.rgb, own_colour.a * opacity); }
