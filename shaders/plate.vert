// Rectangles with round corners, in pixels from the top left of the viewport.
layout(location = 0) in vec2 place_px;
layout(location = 1) in vec2 from_centre_px;
layout(location = 2) in vec2 half_px;
layout(location = 3) in vec2 rim_px;
layout(location = 4) in vec4 colour; // sRGB, straight alpha

uniform vec2 viewport_px;

out vec2 at_px;
flat out vec2 half_size_px;
flat out vec2 rim; // radius of the corners; width of the border, 0 where all is filled
flat out vec4 own_colour;

void main() {
    at_px = from_centre_px;
    half_size_px = half_px;
    rim = rim_px;
    own_colour = colour;
    gl_Position = vec4(vec2(2.0, -2.0) * place_px / viewport_px + vec2(-1.0, 1.0), 0.0, 1.0);
}
