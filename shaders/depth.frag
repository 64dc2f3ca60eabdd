// Only the depth is written.
#ifdef MASK
in float base_alpha;
in vec2 base_coordinate;

uniform sampler2D base_texture;
uniform float alpha_cutoff;
#endif

void main() {
#ifdef MASK
    if (base_alpha * texture(base_texture, base_coordinate).a < alpha_cutoff) {
        discard;
    }
#endif
}
