// Mouse control of camera and hand in the scene view.
#pragma once

#include "app/stage/touch_by_click.h"
#include "app/view/camera.h"
#include "app/widgets/rectangle.h"
#include "engine/session/session.h"

#include <functional>
#include <optional>

namespace springdrive::app {

/// What is seen at a pixel of the view.
struct SeenAt {
    std::function<Vector3(const PixelPoint &)> point;
    std::function<std::optional<SurfacePlace>(const PixelPoint &)> touchable; ///< of the scene
};

/// The left button on the scene's surface lets the hand press there, and slide after the cursor;
/// beside it, or with Shift, its drag moves the hand in the view plane. The wheel meanwhile: depth.
/// Right drag orbits, middle drag pans, the wheel zooms to the cursor. A drag belongs to the view
/// in which it began.
class MouseInView {
public:
    /// @param may_move_hand  false while something else than the present is shown
    void apply(session::Session &session, Camera &camera, const Rectangle &view, bool may_move_hand,
               const SeenAt &seen);

    [[nodiscard]] bool holds_hand() const {
        return dragging_ == Drag::hand || dragging_ == Drag::touch;
    }

private:
    enum class Drag : unsigned char { none, hand, touch, orbit, pan };

    void begin_with_hand(const session::Session &session, const SeenAt &seen,
                         const PixelPoint &pixel, bool may_move_hand);
    void move_touch(session::Session &session, const SeenAt &seen, const PixelPoint &pixel);

    Drag dragging_ = Drag::none;
    Vector3 grabbed_m_{Vector3::Zero()}; ///< position of the hand by the mouse, within reach or not
    TouchByClick touch_;
    Vector3 asked_m_{Vector3::Zero()}; ///< the hand's target that `touch_` led to last
};

} // namespace springdrive::app
