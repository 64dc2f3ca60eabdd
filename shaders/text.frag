// Letters lie on whole pixels: each takes exactly one texel.
in vec2 in_letters;

uniform sampler2D letters; // red: how much of the pixel is covered
uniform vec4 colour; // sRGB, straight alpha

out vec4 pixel;

void main() {
    float covered = texelFetch(letters, ivec2(in_letters), 0).r;
    pixel = vec4(colour.rgb, colour.a * covered);
}
