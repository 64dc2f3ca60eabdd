// glTF's metallic-roughness materials in linear light: hemispherical light from sky and ground, a
// key light from the upper left that is fixed in the world and casts shadows, and a weak light at
// the eye for contrast on all sides, each scattered by the base colour and reflected by the
// surface; and on what is below it, the tip's contact shadow. The nearer to the floor, the darker it
// is, by little: steps are told apart from above, too. What is brighter than a screen is compressed.
//
// Light is in units in which a white matt surface square to a light of 1 has the brightness 1.
in vec3 world_position_m;
in vec3 world_normal;
in vec3 in_light; // place in the shadow maps
in vec4 base_colour;
in vec2 base_coordinate;
#ifdef TANGENTS
in vec4 world_tangent; // and the bitangent's sign
#endif

uniform sampler2D base_texture; // sRGB, decoded by the sampler
uniform sampler2DShadow scene_shadow;
uniform sampler2DShadow moving_shadow;
uniform mat4 light; // from the world to the shadow maps
uniform vec3 key_direction; // unit, towards the light
uniform vec3 eye_m;
uniform vec3 tip_m;
uniform float floor_height_m;
uniform float glow; // 0: lit by the lights only, 1: the base colour itself
uniform float roughness; // 0 mirror, 1 matt
#ifdef METAL
uniform float metallic; // 0 dielectric, 1 metal
#endif
#ifdef FINISH_TEXTURE
uniform sampler2D finish_texture; // green multiplies roughness, blue metallic
#endif
#ifdef NORMAL_TEXTURE
uniform sampler2D normal_texture;
uniform float normal_scale; // of red and green
#endif
#ifdef OCCLUSION_TEXTURE
uniform sampler2D occlusion_texture; // red
uniform float occlusion_strength;
#endif
#ifdef EMISSION
uniform vec3 emission; // linear
uniform sampler2D emissive_texture;
#endif
#ifdef MASK
uniform float alpha_cutoff;
#endif

out vec4 pixel;

const vec3 kKey = vec3(1.00, 0.96, 0.90) * 0.64;
const vec3 kSky = vec3(0.50, 0.55, 0.62) * 0.62;
const vec3 kGround = vec3(0.34, 0.32, 0.30) * 0.55;
const vec3 kEye = vec3(0.10);
const float kDielectric = 0.04; // reflectance at normal incidence
const float kLightSpread = 0.04; // of the lights themselves, in highlights
const float kTwilight = 0.35;

// What polished metal mirrors beside sky and ground: a broad window in the user's back.
const vec3 kWindow = vec3(1.00, 1.00, 0.97) * 1.3;
const vec3 kToWindow = vec3(0.50, 0.62, 0.6046); // unit
const float kWindowSpread = 0.12;
const float kHorizonSpread = 0.30; // of a polished surface

const float kUncompressed = 0.60; // up to this brightness

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

// How much a surface reflects of light from all around, as the factor and the summand of its
// reflectance at normal incidence (Karis 2014, "Physically based shading on mobile").
vec2 reflected_from_around(float rough, float facing) {
    vec4 r = rough * vec4(-1.0, -0.0275, -0.572, 0.022) + vec4(1.0, 0.0425, 1.04, -0.04);
    float edge = min(r.x * r.x, exp2(-9.28 * facing)) * r.x + r.y;
    return vec2(-1.04, 1.04) * edge + r.zw;
}

vec3 hemisphere(float upwards) { return mix(kGround, kSky, 0.5 + 0.5 * upwards); }

#ifdef METAL
#define REFLECTANCE vec3

// What is mirrored around `direction`, unsharp by `spread`, from 0 to 1.
vec3 surroundings(vec3 direction, float spread) {
    float wide = kWindowSpread + spread;
    float window = kWindowSpread / wide * exp2((dot(direction, kToWindow) - 1.0) * 1.5 / wide);
    float horizon = mix(kHorizonSpread, 1.0, spread);
    float upwards = smoothstep(-horizon, horizon, direction.y);
    return mix(kGround, kSky, upwards) + kWindow * window * (1.0 - spread);
}
#else
#define REFLECTANCE float
#endif

// GGX with Schlick's Fresnel term; the visibility by Hammon (2017). Times π, by the units of light.
REFLECTANCE highlight(REFLECTANCE straight, float spread, vec3 n, vec3 to_eye, float facing, float key) {
    vec3 half_way = normalize(key_direction + to_eye);
    float across = clamp(dot(n, half_way), 0.0, 1.0);
    float d = across * across * (spread * spread - 1.0) + 1.0;
    float lobe = spread * spread / (d * d);
    float visible = 0.5 / mix(2.0 * key * facing, key + facing, spread);
    float oblique = 1.0 - clamp(dot(to_eye, half_way), 0.0, 1.0);
    float squared = oblique * oblique;
    return (straight + (1.0 - straight) * (squared * squared * oblique)) * (lobe * visible);
}

// @param n unit, as lit; `face` the same without a normal map
vec3 lit(vec3 base, float metal, float rough, float open, vec3 n, vec3 face, vec3 to_eye) {
    float facing = clamp(dot(n, to_eye), 1e-3, 1.0);
    float key = dot(n, key_direction);
    float arriving = key > 0.0 && glow == 0.0 ? unshadowed(face) : 1.0;
    float height = clamp((world_position_m.y - floor_height_m) / kBright_m, 0.0, 1.0);
    float dimmed = mix(kAtTheFloor, 1.0, height) *
                   (1.0 - (1.0 - glow) * tip_shadow(world_position_m, n.y));
    vec3 ambient = (hemisphere(n.y) + kEye * facing) * open;
    vec3 light = (ambient + kKey * max(key, 0.0) * arriving) * dimmed;

    vec2 around = reflected_from_around(rough, facing);
    float spread = max(rough * rough, kLightSpread);
#ifdef METAL
    vec3 straight = mix(vec3(kDielectric), base, metal);
    // What a rough surface reflects onto itself leaves it in all directions (Fdez-Agüera 2019).
    vec3 mean = straight + (1.0 - straight) / 21.0;
    float lost = max(1.0 - around.x - around.y, 0.0);
    vec3 again = (straight * around.x + around.y) * mean * lost / (1.0 - mean * lost);
    vec3 diffuse = base * (1.0 - metal) + again;
    vec3 mirrored = surroundings(normalize(mix(reflect(-to_eye, n), n, rough * rough)), rough * rough);
    mirrored = (mirrored + kEye * facing) * open;
#else
    vec3 diffuse = base;
    float straight = kDielectric;
    float upwards = mix(2.0 * facing * n.y - to_eye.y, n.y, rough * rough);
    vec3 mirrored = (hemisphere(upwards) + kEye * facing) * open;
#endif
    vec3 gloss = (straight * around.x + around.y) * mirrored * dimmed;
    if (key > 0.0) {
        float risen = min(key / kTwilight, 1.0); // the light is no point: it sets gradually
        gloss += highlight(straight, spread, n, to_eye, facing, key) * kKey * key * risen * arriving;
    }
    return diffuse * mix(light, vec3(1.0), glow) + gloss;
}

#ifdef NORMAL_TEXTURE
// The normal of the map. glTF's green points up the picture, against the second coordinate.
// @param n unit, towards the eye
vec3 mapped(vec3 n) {
    vec3 slope = 2.0 * texture(normal_texture, base_coordinate).xyz - 1.0;
    slope.xy *= gl_FrontFacing ? normal_scale : -normal_scale; // behind a bump is a dent
#ifdef TANGENTS
    vec3 outwards = gl_FrontFacing ? n : -n;
    vec3 tangent = world_tangent.xyz - dot(world_tangent.xyz, n) * n;
    tangent *= inversesqrt(max(dot(tangent, tangent), 1e-12));
    vec3 bitangent = cross(outwards, tangent) * world_tangent.w;
#else
    // By how position and texture coordinates change over the screen (Schüler 2013).
    vec3 right_m = dFdx(world_position_m);
    vec3 up_m = dFdy(world_position_m);
    vec2 right_uv = dFdx(base_coordinate);
    vec2 up_uv = dFdy(base_coordinate);
    vec3 across_up = cross(up_m, n);
    vec3 across_right = cross(n, right_m);
    vec3 tangent = across_up * right_uv.x + across_right * up_uv.x;
    vec3 bitangent = -(across_up * right_uv.y + across_right * up_uv.y);
    float longest = max(dot(tangent, tangent), dot(bitangent, bitangent));
    float unit = longest > 0.0 ? inversesqrt(longest) : 0.0;
    tangent *= unit;
    bitangent *= unit;
#endif
    return normalize(tangent * slope.x + bitangent * slope.y + n * max(slope.z, 1e-3));
}
#endif

// Up to kUncompressed as it is, beyond it towards 1, so that white keeps its shading.
vec3 compressed(vec3 colour) {
    vec3 beyond = max(colour - kUncompressed, 0.0);
    return min(colour, kUncompressed) + beyond / (1.0 + beyond / (1.0 - kUncompressed));
}

void main() {
    vec4 base = base_colour * texture(base_texture, base_coordinate);
    vec3 face = normalize(world_normal);
    if (!gl_FrontFacing) {
        face = -face;
    }
    vec3 n = face;
    float metal = 0.0;
    float rough = roughness;
    float open = 1.0; // to the light from all around
#ifdef METAL
    metal = metallic;
#endif
#ifdef FINISH_TEXTURE
    vec3 finish = texture(finish_texture, base_coordinate).rgb;
    metal *= finish.b;
    rough *= finish.g;
#endif
#ifdef NORMAL_TEXTURE
    n = mapped(face);
#endif
#ifdef OCCLUSION_TEXTURE
    open = mix(1.0, texture(occlusion_texture, base_coordinate).r, occlusion_strength);
#endif
    vec3 linear = lit(base.rgb, metal, rough, open, n, face, normalize(eye_m - world_position_m));
#ifdef EMISSION
    linear += emission * texture(emissive_texture, base_coordinate).rgb;
#endif
    // Discarded last, as textures are read with derivatives between pixels. Cut-out texels must not
    // write depth.
#ifdef TRANSLUCENT
    if (base.a < 0.01) {
        discard;
    }
#endif
#ifdef MASK
    if (base.a < alpha_cutoff) {
        discard;
    }
    base.a = 1.0;
#endif
    pixel = vec4(pow(compressed(linear), vec3(1.0 / 2.2)), base.a);
}
