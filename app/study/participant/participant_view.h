// Draws a ParticipantPicture into a texture of its own, by an ImGui context of its own; and the
// scene in it.
#pragma once

#include "app/study/participant/participant_layout.h"
#include "app/study/participant/participant_picture.h"
#include "app/view/camera.h"
#include "app/view/gl_objects.h"
#include "app/view/painters.h"
#include "app/view/scene_meshes.h"
#include "app/view/shadows.h"
#include "app/widgets/rectangle.h"
#include "engine/scene/scene.h"

#include <glm/vec3.hpp>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace springdrive::app::study_screen {

/// Looks at the spot from the participant's side and from above, steeper than the experimenter's
/// view; so near that the surroundings of a hand's movement are seen, or the whole of a smaller
/// scene. Depends on scene and spot alone.
[[nodiscard]] Camera camera_on(const scene::TouchSpot &spot, const scene::Scene &scene);

/// The scene as a participant sees it: lit and with its shadows, the marked spot as a ring, and a
/// ball. No device, no arrow, no caption, and no colour that could tell anything.
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

/// Must be used with one and the same context current. What it draws depends on nothing but
/// picture, size, scene and spot.
class ParticipantView {
public:
    /// @param samples  per pixel of the scene, as for `Renderer`
    /// @throw InputError if there is no font, with the remedy.
    explicit ParticipantView(int samples = 4);
    ParticipantView(const ParticipantView &) = delete;
    ParticipantView &operator=(const ParticipantView &) = delete;

    /// The scene for pictures that show it, uploaded at once; `scene` is not used afterwards.
    /// @param spot  marked by a ring; the camera looks on it. @param floor_height_m  as in
    /// ViewState
    void set_scene(const scene::Scene &scene, const scene::TouchSpot &spot, double floor_height_m);

    /// Draws the picture anew unless it, the size and the scene are those of the last call. Leaves
    /// framebuffer 0 bound if it draws. @pre width and height > 0
    void draw(const ParticipantPicture &picture, int width, int height);

    /// Of the last picture.
    [[nodiscard]] const ParticipantLayout &layout() const { return layout_; }
    /// Vertices of all but the scene that have been drawn so far.
    [[nodiscard]] std::size_t vertices() const { return vertices_; }
    /// The last picture to framebuffer 0, which has this size. @pre there is one
    void copy_to_window(int width, int height) const;

    /// The last picture: RGB, top row first. Waits for the drawing.
    [[nodiscard]] std::vector<std::uint8_t> pixels() const;

private:
    struct Target {
        Target(int wide, int high);

        Texture2D texture;
        Framebuffer framebuffer;
        int width;
        int height;
    };

    void draw_page();

    Letters letters_;
    std::unique_ptr<ImGuiContext, void (*)(ImGuiContext *)> gui_;
    int letters_version_ = 0; ///< of ImGui's texture
    ParticipantScene scene_;
    ParticipantPicture picture_;
    ParticipantLayout layout_;
    std::optional<Target> target_;
    std::size_t vertices_ = 0;
    bool is_outdated_ = true;
};

/// A curve without its labels.
void draw_curve(const CurveChart &chart, const OwnCurve &curve, ImDrawList &list);

} // namespace springdrive::app::study_screen
