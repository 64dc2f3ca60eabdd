// Where the scene is looked at from: by the mouse, by keys, or from a viewpoint that keeps
// everything in the picture.
#pragma once

#include "app/stage/touch_by_click.h"
#include "app/view/camera.h"
#include "app/view/view_state.h"
#include "app/widgets/rectangle.h"
#include "app/window/window.h"
#include "engine/session/session.h"

#include <optional>
#include <string_view>

namespace springdrive::app {

class Renderer;

/// What a view shows of a tick: device, contact and force; the hand's target is at the tip.
/// @param surface  that is touched
[[nodiscard]] ViewState view_of(const servo::ServoSample &now,
                                const device::DeviceDescription &device,
                                const contact::HapticSurface &surface);

/// Mouse: the left button on the scene's surface lets the hand press there, and slide after the
/// cursor; beside it, or with Shift, its drag moves the hand in the view plane. The wheel
/// meanwhile: depth. Right drag orbits, middle drag pans, the wheel zooms to the cursor. A drag
/// belongs to the view in which it began.
class ViewControl {
public:
    /// From the next `update` on, with everything in the picture, until the camera is moved.
    void look_from(Viewpoint viewpoint) {
        kept_ = viewpoint;
        is_framed_ = false;
    }

    /// Turns, zooms or chooses a viewpoint. False if the key is for none of that.
    bool obey(std::string_view key);

    /// Applies the mouse, and keeps the viewpoint when the view's size or the device has changed.
    /// @param view  of the scene in the window
    /// @param free  its part over which nothing else is drawn
    /// @param may_move_hand  false while something else than the present is shown
    void update(session::Session &session, const ViewState &state, const Rectangle &view,
                const Rectangle &free, bool may_move_hand);

    /// Enters into the window's report which part of the window device and scene take.
    void report(const session::Session &session, const ViewState &state,
                const Rectangle &view) const;

    /// The scene in that part of the window.
    void draw(Renderer &renderer, const ViewState &state, const Rectangle &view,
              const Window &window) const;

    [[nodiscard]] const Camera &camera() const { return camera_; }
    [[nodiscard]] bool holds_hand() const {
        return dragging_ == Drag::hand || dragging_ == Drag::touch;
    }

private:
    enum class Drag : unsigned char { none, hand, touch, orbit, pan };

    void apply_mouse(session::Session &session, const ViewState &state, const Rectangle &view,
                     bool may_move_hand);
    void begin_with_hand(const session::Session &session, const PixelPoint &pixel,
                         const PixelSize &size, bool may_move_hand);
    void move_touch(session::Session &session, const PixelPoint &pixel, const PixelSize &size);

    Camera camera_;
    Drag dragging_ = Drag::none;
    Vector3 grabbed_m_{Vector3::Zero()}; ///< position of the hand by the mouse, within reach or not
    TouchByClick touch_;
    Vector3 requested_m_{Vector3::Zero()}; ///< the hand's target that `touch_` led to last
    std::optional<Viewpoint> kept_ = Viewpoint::home; ///< until the camera is moved
    bool is_framed_ = false;
    PixelSize framed_size_;                  ///< of the view, then
    Rectangle framed_free_{};                ///< its free part, then
    Vector3 framed_base_m_{Vector3::Zero()}; ///< of the device, then
};

} // namespace springdrive::app
