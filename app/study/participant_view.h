// Draws a ParticipantPicture into a texture of its own.
#pragma once

#include "app/study/participant_layout.h"
#include "app/study/participant_picture.h"
#include "app/study/participant_scene.h"
#include "app/view/gl_objects.h"
#include "app/view/plate_painter.h"
#include "app/view/text_painter.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace springdrive::app::study_screen {

/// Must be used with the main window's context current; its texture may be drawn by a context that
/// shares objects with it.
class ParticipantView {
public:
    /// @throw InputError if there is no font, with the remedy.
    /// @param samples  per pixel of the scene, as for `Renderer`
    explicit ParticipantView(int samples = 4);

    /// The scene for pictures that show it, uploaded at once. @param spot  marked by a ring, on
    /// which the camera looks. @param floor_height_m  as in ViewState
    void set_scene(const scene::Scene &scene, const MarkedSpot &spot, double floor_height_m);

    /// Draws the picture anew, if it, the size or the scene is another than at the last call.
    /// Leaves framebuffer 0 bound.
    /// @pre width and height > 0
    void draw(const ParticipantPicture &picture, int width, int height);

    /// Of the last picture.
    [[nodiscard]] const ParticipantLayout &layout() const { return layout_; }
    [[nodiscard]] int width() const { return width_; }
    [[nodiscard]] int height() const { return height_; }
    [[nodiscard]] GLuint texture() const; ///< RGBA8, bottom row first; 0 before the first picture

    /// Its pixels: RGB, top row first. Waits for the drawing.
    [[nodiscard]] std::vector<std::uint8_t> pixels() const;

private:
    struct Target;

    Typeface typeface_;
    TextPainter text_;
    PlatePainter plates_;
    ParticipantScene scene_;
    ParticipantPicture picture_; ///< in the texture
    ParticipantLayout layout_;
    int width_ = 0;
    int height_ = 0;
    bool is_outdated_ = true;
    std::unique_ptr<Target> target_;

public:
    ~ParticipantView();
    ParticipantView(const ParticipantView &) = delete;
    ParticipantView &operator=(const ParticipantView &) = delete;
};

} // namespace springdrive::app::study_screen
