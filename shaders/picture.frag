// A finished picture over the whole viewport.
in vec2 screen; // 0 to 1, from the bottom left

uniform sampler2D picture;

out vec4 pixel;

void main() { pixel = vec4(texture(picture, screen).rgb, 1.0); }
