// Gaussian in one direction, over nine texels in five reads between texels.
in vec2 screen;

uniform sampler2D mask;
uniform vec2 step; // to the next texel

out float darkness;

void main() {
    float sum = 0.2270 * texture(mask, screen).r;
    sum += 0.3162 * (texture(mask, screen + 1.3846 * step).r + texture(mask, screen - 1.3846 * step).r);
    sum += 0.0703 * (texture(mask, screen + 3.2308 * step).r + texture(mask, screen - 3.2308 * step).r);
    darkness = sum;
}
