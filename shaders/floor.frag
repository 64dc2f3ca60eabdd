// The floor: a grid of 1 cm and 5 cm from the device's origin, and the shadows of objects above it.
in vec2 world_xz_m;

uniform vec2 centre_m;
uniform float half_size_m;
uniform vec2 shadow_centre_m;
uniform float shadow_half_size_m;
uniform sampler2D scene_shadow;
uniform sampler2D moving_shadow;
uniform float opacity;
uniform float pixel_scale; // framebuffer pixels per layout pixel

out vec4 pixel;

const vec3 kFloor = vec3(0.500, 0.535, 0.570); // sRGB
const vec3 kLine = vec3(0.250, 0.280, 0.320);
const vec3 kShadow = vec3(0.090, 0.105, 0.130);
const float kFineLine = 0.22;
const float kBoldLine = 0.42;
const float kDarkest = 0.78;

// The fraction of this pixel that grid lines cover; fades out where the cells become too small.
float grid(float spacing_m, float half_width_px) {
    vec2 pixel_m = max(fwidth(world_xz_m), vec2(1e-7));
    vec2 distance_m = abs(fract(world_xz_m / spacing_m - 0.5) - 0.5) * spacing_m;
    vec2 covered = clamp(half_width_px * pixel_scale + 0.5 - distance_m / pixel_m, 0.0, 1.0);
    covered *= smoothstep(2.5, 9.0, spacing_m / (pixel_m * pixel_scale));
    return max(covered.x, covered.y);
}

float shadow() {
    vec2 coordinate = 0.5 + 0.5 * (world_xz_m - shadow_centre_m) / shadow_half_size_m;
    return max(texture(scene_shadow, coordinate).r, texture(moving_shadow, coordinate).r);
}

void main() {
    float away = length(world_xz_m - centre_m) / half_size_m;
    float near = 1.0 - smoothstep(0.25, 1.0, away);
    float line = max(kFineLine * grid(0.01, 0.5), kBoldLine * grid(0.05, 0.8));
    vec3 surface = mix(mix(kFloor, kLine, line), kShadow, kDarkest * shadow());
    pixel = vec4(surface, near * opacity);
}
