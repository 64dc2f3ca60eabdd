// A vertical gradient, dithered with noise below one grey level to avoid banding.
in vec2 screen;

out vec4 pixel;

const vec3 kTop = vec3(0.205, 0.235, 0.275); // sRGB
const vec3 kBottom = vec3(0.395, 0.430, 0.470);

void main() {
    // Interleaved gradient noise (Jimenez 2014).
    float noise = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
    float lower = 1.0 - screen.y;
    pixel = vec4(mix(kTop, kBottom, lower) + (noise - 0.5) / 255.0, 1.0);
}
