// The lower an object, the darker its shadow. Blended so that the darkest value is kept.
in float height_m;
#ifdef MASK
in float base_alpha;
in vec2 base_coordinate;

uniform sampler2D base_texture;
uniform float alpha_cutoff;
#endif

out float darkness;

const float kHalfAsDark_m = 0.12;

void main() {
#ifdef MASK
    if (base_alpha * texture(base_texture, base_coordinate).a < alpha_cutoff) {
        discard;
    }
#endif
    darkness = height_m < 0.0 ? 0.0 : 1.0 / (1.0 + height_m / kHalfAsDark_m);
}
