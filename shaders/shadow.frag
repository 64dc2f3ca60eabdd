// The lower an object, the darker its shadow. Blended so that the darkest value is kept.
in float height_m;

out float darkness;

const float kHalfAsDark_m = 0.12;

void main() {
    darkness = height_m < 0.0 ? 0.0 : 1.0 / (1.0 + height_m / kHalfAsDark_m);
}
