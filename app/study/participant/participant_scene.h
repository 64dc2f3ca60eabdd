// The scene as a participant sees it: lit and with its shadows, the marked spot as a ring, and a
// ball. No device, no arrow, no caption, and no colour that could tell anything.
#pragma once

#include "app/view/camera.h"
#include "app/view/gl_objects.h"
#include "app/view/painters.h"
#include "app/view/scene_meshes.h"
#include "app/view/shadows.h"
#include "app/widgets/rectangle.h"
#include "engine/scene/lesson.h"
#include "engine/scene/scene.h"

#include <glm/vec3.hpp>

#include <optional>

namespace springdrive::app::study_screen {

/// Looks at the spot from the participant's side and from above, steeper than the experimenter's
/// view; so near that the surroundings of a hand's movement are seen, or the whole of a smaller
/// scene. Depends on scene and spot alone.
[[nodiscard]] Camera camera_on(const scene::TouchSpot &spot, const scene::Scene &scene);

class ParticipantScene {
public:
    /// @param samples  per pixel
    explicit ParticipantScene(int samples);

    /// Uploads the scene, however long that takes. @param floor_height_m  as in ViewState
    /// @throw std::runtime_error if OpenGL cannot hold it
    void set(const scene::Scene &scene, const scene::TouchSpot &spot, double floor_height_m);

    /// Draws into a part of a framebuffer, in its pixels from the top left, which is bound
    /// afterwards; over `background`, which is in sRGB. Leaves depth test, blending and culling
    /// off. @param height  of the framebuffer
    void draw(GLuint framebuffer, const Rectangle &part, int height,
              const std::optional<Vector3> &tip_m, const glm::vec3 &background);

private:
    void cast_shadows(const std::vector<Solid> &ball);
    const Program &begin(const LitVariant &variant, const glm::mat4 &view_projection);

    LitPrograms lit_;
    SolidPainter painter_;
    SceneMeshes meshes_;
    Program depth_;
    Program depth_masked_;
    ShadowMap scene_shadow_; ///< cast once
    ShadowMap ball_shadow_;
    MultisampledTarget target_;
    Camera camera_;
    scene::TouchSpot spot_;
    glm::mat4 light_{1.0F};
    float floor_height_m_ = 0.0F;
    glm::vec3 tip_m_{0.0F};
    bool scene_is_cast_ = false;
};

} // namespace springdrive::app::study_screen
