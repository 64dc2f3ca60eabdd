// Draws a ParticipantPicture into a texture of its own, by an ImGui context of its own.
#pragma once

#include "app/study/participant/participant_layout.h"
#include "app/study/participant/participant_picture.h"
#include "app/study/participant/participant_scene.h"
#include "app/view/gl_objects.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace springdrive::app::study_screen {

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
