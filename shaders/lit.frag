// Linear lighting: hemispherical light from sky and ground, a key light from the upper left that is
// fixed in the world and casts shadows, a weak light at the eye for contrast on all sides, a
// highlight and a rim; and on what is below it, the tip's contact shadow. The nearer to the floor,
// the darker it is, by little: steps are told apart from above, too.
in vec3 world_position_m;
in vec3 world_normal;
in vec3 in_light; // place in the shadow maps
in vec4 base_colour;
in vec2 base_coordinate;

uniform sampler2D base_texture; // sRGB, decoded by the sampler
uniform sampler2DShadow scene_shadow;
uniform sampler2DShadow moving_shadow;
uniform mat4 light; // from the world to the shadow maps
uniform vec3 key_direction; // unit, towards the light
uniform vec3 eye_m;
uniform vec3 tip_m;
uniform float floor_height_m;
uniform float glow; // 0: lit by the lights only, 1: the base colour itself
#ifdef TRANSLUCENT
#define EMISSIVE
#endif
#ifdef EMISSIVE
uniform vec3 emission; // linear
uniform sampler2D emissive_texture;
#endif

out vec4 pixel;

const vec3 kKey = vec3(1.00, 0.96, 0.90) * 0.64;
const vec3 kSky = vec3(0.50, 0.55, 0.62) * 0.62;
const vec3 kGround = vec3(0.34, 0.32, 0.30) * 0.55;
const vec3 kEye = vec3(0.10);
const float kHighlight = 0.16;
const float kRim = 0.18;

const float kTipShadow_m = 5.0e-3; // radius in contact
const float kTipShadowSpread = 0.12; // of the radius, per height
const float kTipDarkest = 0.75;

const float kAtTheFloor = 0.62; // share of the light
const float kBright_m = 0.09; // height from which all of it is there

// Offsets against surfaces that shadow themselves, as they are drawn into the maps in steps.
const float kOffTheSurface_m = 1.2e-3;
const float kTowardsLight = 1.0e-3; // of the maps' depth

// What of the light the tip takes straight below itself, the more the nearer it is.
float tip_shadow(vec3 at_m, float upwards) {
    vec3 to_tip_m = tip_m - at_m;
    float wide_m = kTipShadow_m + kTipShadowSpread * max(to_tip_m.y, 0.0);
    float away = dot(to_tip_m.xz, to_tip_m.xz) / (wide_m * wide_m);
    float narrow = kTipShadow_m / wide_m;
    bool is_below = to_tip_m.y > -kTipShadow_m && upwards > 0.0;
    return is_below ? kTipDarkest * narrow * max(1.0 - away, 0.0) * upwards : 0.0;
}

float to_the_32nd(float x) {
    x *= x;
    x *= x;
    x *= x;
    x *= x;
    return x * x;
}

// The share of the key light that arrives, over four places for a soft edge.
float unshadowed(vec3 n) {
    vec3 at = in_light + mat3(light) * (kOffTheSurface_m * n) - vec3(0.0, 0.0, kTowardsLight);
    vec2 step = vec2(0.75) / vec2(textureSize(scene_shadow, 0));
    float sum = 0.0;
    for (int i = 0; i < 4; ++i) {
        vec3 beside = at + vec3(step * vec2((i & 1) * 2 - 1, (i & 2) - 1), 0.0);
        sum += min(texture(scene_shadow, beside), texture(moving_shadow, beside));
    }
    return 0.25 * sum;
}

vec3 lit(vec3 base, vec3 n, vec3 to_eye) {
    float facing = max(dot(n, to_eye), 0.0);
    float key = dot(n, key_direction);
    float arriving = key > 0.0 && glow == 0.0 ? unshadowed(n) : 1.0;
    vec3 ambient = mix(kGround, kSky, 0.5 + 0.5 * n.y) + kEye * facing;
    vec3 light = ambient + kKey * max(key, 0.0) * arriving;
    float height = clamp((world_position_m.y - floor_height_m) / kBright_m, 0.0, 1.0);
    light *= mix(kAtTheFloor, 1.0, height);
    light *= 1.0 - (1.0 - glow) * tip_shadow(world_position_m, n.y);

    vec3 half_way = normalize(key_direction + to_eye);
    float highlight = kHighlight * arriving * to_the_32nd(max(dot(n, half_way), 0.0));
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
