// Smooth edges by the distance to the outline.
in vec2 at_px;
flat in vec2 half_size_px;
flat in vec2 rim;
flat in vec4 own_colour;

out vec4 pixel;

void main() {
    vec2 beyond = abs(at_px) - half_size_px + rim.x;
    float outside_px = length(max(beyond, 0.0)) + min(max(beyond.x, beyond.y), 0.0) - rim.x;
    float covered = clamp(0.5 - outside_px, 0.0, 1.0);
    if (rim.y > 0.0) {
        covered *= clamp(0.5 + outside_px + rim.y, 0.0, 1.0);
    }
    pixel = vec4(own_colour.rgb, own_colour.a * covered);
}
