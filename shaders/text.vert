// Letters from a texture, in pixels from the top left of the viewport.
layout(location = 0) in vec2 place_px;
layout(location = 1) in vec2 texel;

uniform vec2 viewport_px;

out vec2 in_letters;

void main() {
    in_letters = texel;
    gl_Position = vec4(vec2(2.0, -2.0) * place_px / viewport_px + vec2(-1.0, 1.0), 0.0, 1.0);
}
