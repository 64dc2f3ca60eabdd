// The lower something hangs, the darker its shadow. Blended so that the darkest counts.
in float height_m;

out float darkness;

const float kHalfAsDark_m = 0.12;

void main() {
    darkness = height_m < 0.0 ? 0.0 : 1.0 / (1.0 + height_m / kHalfAsDark_m);
}
