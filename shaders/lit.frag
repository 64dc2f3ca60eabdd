// Linear lighting: hemispherical light from sky and ground, a key light from the upper left that is
// fixed in the world, a weak light at the eye for contrast on all sides, a highlight and a rim.
in vec3 world_position_m;
in vec3 world_normal;
in vec4 base_colour;
in vec2 base_coordinate;

uniform sampler2D base_texture; // sRGB, decoded by the sampler
uniform vec3 eye_m;
uniform float glow; // 0: lit by the lights only, 1: the base colour itself
#ifdef TRANSLUCENT
#define EMISSIVE
#endif
#ifdef EMISSIVE
uniform vec3 emission; // linear
uniform sampler2D emissive_texture;
#endif

out vec4 pixel;

const vec3 kKeyDirection = vec3(-0.448, 0.796, 0.408); // unit, towards the light
const vec3 kKey = vec3(1.00, 0.96, 0.90) * 0.62;
const vec3 kSky = vec3(0.50, 0.55, 0.62) * 0.58;
const vec3 kGround = vec3(0.34, 0.32, 0.30) * 0.45;
const vec3 kEye = vec3(0.10);
const float kHighlight = 0.16;
const float kRim = 0.18;

float to_the_32nd(float x) {
    x *= x;
    x *= x;
    x *= x;
    x *= x;
    return x * x;
}

vec3 lit(vec3 base, vec3 n, vec3 to_eye) {
    float facing = max(dot(n, to_eye), 0.0);
    float key = 0.5 + 0.5 * dot(n, kKeyDirection);
    key *= key; // half Lambert: no hard terminator
    vec3 light = mix(kGround, kSky, 0.5 + 0.5 * n.y) + kKey * key + kEye * facing;

    vec3 half_way = normalize(kKeyDirection + to_eye);
    float highlight = kHighlight * to_the_32nd(max(dot(n, half_way), 0.0));
    float edge = 1.0 - facing;
    float rim = kRim * edge * edge * edge * (0.5 + 0.5 * n.y);
    return base * mix(light, vec3(1.0), glow) + highlight * kKey + rim * kSky;
}

void main() {
    vec4 base = base_colour * texture(base_texture, base_coordinate);
#ifdef TRANSLUCENT
    // Cut-out texels must not write depth.
    if (base.a < 0.01) {
        discard;
    }
#endif
    vec3 n = normalize(world_normal);
    if (!gl_FrontFacing) {
        n = -n;
    }
    vec3 linear = lit(base.rgb, n, normalize(eye_m - world_position_m));
#ifdef EMISSIVE
    linear += emission * texture(emissive_texture, base_coordinate).rgb;
#endif
    pixel = vec4(pow(linear, vec3(1.0 / 2.2)), base.a);
}
