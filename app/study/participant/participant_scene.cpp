#include "app/study/participant/participant_scene.h"

#include "app/view/embedded_shaders.h"
#include "app/view/gl_vector.h"

#include <algorithm>
#include <array>
#include <limits>
#include <string_view>

namespace springdrive::app::study_screen {

namespace {

constexpr double kMinHalfHeight_m = 0.035; // of what is seen about the spot
constexpr double kMaxHalfHeight_m = 0.06;
constexpr double kSteeper_px = 35.0; // of a mouse that would turn the camera so, by 14°
constexpr double kMinFacing = 0.15;  // cosine between the spot's normal and the line of sight

constexpr Colour kRingColour{0.96F, 0.97F, 0.98F};
constexpr double kRingRadius_m = 0.005;
constexpr Colour kBallColour{0.98F, 0.62F, 0.16F};
constexpr double kBallRadius_m = 2.2e-3;
constexpr float kGlow = 0.6F; // both keep their colour on the unlit side
constexpr float kSatinBall = 0.5F;
constexpr float kHiddenBall = 0.35F; // opacity of the ball behind something

constexpr int kSceneShadow_px = 1024;
constexpr int kBallShadow_px = 512;
constexpr double kMinLight_m = 0.1; // radius of what the key light sees
constexpr std::array<std::string_view, 1> kMasked{"MASK"};

Camera looking_from(Viewpoint viewpoint) {
    Camera camera;
    camera.look_from(viewpoint);
    if (viewpoint == Viewpoint::home) {
        camera.orbit(0.0, kSteeper_px);
    }
    return camera;
}

/// From the first of the directions from which the spot is seen, or from the best.
Camera facing(const scene::TouchSpot &spot) {
    Camera best = looking_from(Viewpoint::home);
    double most = -1.0;
    for (const Viewpoint viewpoint : {Viewpoint::home, Viewpoint::top, Viewpoint::front}) {
        const Camera camera = looking_from(viewpoint);
        const double cosine = -spot.normal.dot(camera.forward());
        if (cosine > kMinFacing) {
            return camera;
        }
        if (cosine > most) {
            most = cosine;
            best = camera;
        }
    }
    return best;
}

} // namespace

Camera camera_on(const scene::TouchSpot &spot, const scene::Scene &scene) {
    const double half_size_m = 0.5 * (scene.upper_m - scene.lower_m).norm();
    const double half_height_m = std::clamp(half_size_m, kMinHalfHeight_m, kMaxHalfHeight_m);
    const double distance_m = half_height_m / Camera::half_height_per_depth();
    Camera camera = facing(spot);
    camera.place(spot.point_m - distance_m * camera.forward(), distance_m);
    return camera;
}

ParticipantScene::ParticipantScene(int samples)
    : depth_("depth", shaders::depth_vert, shaders::depth_frag),
      depth_masked_("depth, masked", shaders::depth_vert, shaders::depth_frag, kMasked),
      scene_shadow_(kSceneShadow_px), ball_shadow_(kBallShadow_px), target_(samples) {}

void ParticipantScene::set(const scene::Scene &scene, const scene::TouchSpot &spot,
                           double floor_height_m) {
    SceneMeshes meshes(scene);
    meshes.upload(std::numeric_limits<double>::infinity());
    check_gl("uploading the participant's scene");
    for (const LitVariant &variant : meshes.variants()) {
        lit_.with(variant); // compiled here, so that none fails later
    }
    meshes_ = std::move(meshes);
    spot_ = spot;
    camera_ = camera_on(spot, scene);
    floor_height_m_ = static_cast<float>(floor_height_m);
    const Vector3 centre_m = 0.5 * (scene.lower_m + scene.upper_m);
    const double radius_m = std::max(kMinLight_m, 0.5 * (scene.upper_m - scene.lower_m).norm());
    light_ = light_matrix(kTowardsKeyLight, to_glm(centre_m), static_cast<float>(radius_m));
    scene_is_cast_ = false;
}

void ParticipantScene::cast_shadows(const std::vector<Solid> &ball) {
    if (!scene_is_cast_) {
        scene_shadow_.cast(depth_, light_, [&](const Program &depth) {
            depth.set("model", glm::mat4(1.0F));
            meshes_.draw_solid_casters();
            depth_masked_.use();
            depth_masked_.set("light", light_);
            depth_masked_.set("model", glm::mat4(1.0F));
            meshes_.draw_masked_casters(depth_masked_);
        });
        scene_is_cast_ = true;
    }
    ball_shadow_.cast(depth_, light_,
                      [&](const Program &depth) { painter_.draw_geometry(depth, ball); });
}

const Program &ParticipantScene::begin(const LitVariant &variant,
                                       const glm::mat4 &view_projection) {
    const Program &lit = lit_.with(variant);
    lit.set("view_projection", view_projection);
    lit.set("eye_m", to_glm(camera_.eye_m()));
    lit.set("tip_m", tip_m_);
    lit.set("floor_height_m", floor_height_m_);
    lit.set("light", light_);
    lit.set("key_direction", kTowardsKeyLight);
    scene_shadow_.bind(kSceneShadowUnit);
    ball_shadow_.bind(kMovingShadowUnit);
    lit.set("model", glm::mat4(1.0F));
    lit.set("normal_matrix", glm::mat3(1.0F));
    lit.set("colour", glm::vec4(1.0F));
    lit.set("glow", 0.0F);
    lit.set("roughness", kSatinBall);
    return lit;
}

void ParticipantScene::draw(GLuint framebuffer, const Rectangle &part, int height,
                            const std::optional<Vector3> &tip_m, const glm::vec3 &background) {
    // Without a ball its shadow is cast from where nothing is.
    constexpr float kFarBelow_m = -1.0e3F;
    tip_m_ = tip_m ? to_glm(*tip_m) : glm::vec3(0.0F, kFarBelow_m, 0.0F);
    std::vector<Solid> balls;
    if (tip_m) {
        balls.push_back(ball(*tip_m, kBallRadius_m, kBallColour));
    }
    const std::vector<Solid> rings{ring(spot_.point_m, spot_.normal, kRingRadius_m, kRingColour)};
    cast_shadows(balls);

    const int part_width = static_cast<int>(part.size.x);
    const int part_height = static_cast<int>(part.size.y);
    const double aspect = static_cast<double>(part_width) / part_height;
    const glm::mat4 view_projection = camera_.projection(aspect) * camera_.view();
    const auto begin_variant = [&](const LitVariant &variant) -> const Program & {
        return begin(variant, view_projection);
    };
    target_.begin(part_width, part_height);
    glDepthMask(GL_TRUE);
    glClearColor(background.r, background.g, background.b, 1.0F);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_LESS);
    meshes_.draw_opaque(begin_variant);

    glEnable(GL_BLEND);
    glBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
    const Program &lit = begin_variant({});
    lit.set("glow", kGlow);
    painter_.draw(lit, rings);
    glDepthMask(GL_FALSE);
    glDepthFunc(GL_GREATER);
    painter_.draw(lit, balls, kHiddenBall);
    glDepthMask(GL_TRUE);
    glDepthFunc(GL_LESS);
    painter_.draw(lit, balls);
    glDepthMask(GL_FALSE);
    meshes_.draw_translucent(begin_variant, camera_.forward());
    glDepthMask(GL_TRUE);
    glDisable(GL_BLEND);
    glDisable(GL_DEPTH_TEST);
    glBindVertexArray(0);
    target_.end(framebuffer, static_cast<int>(part.corner.x),
                height - static_cast<int>(part.corner.y) - part_height);
}

} // namespace springdrive::app::study_screen
