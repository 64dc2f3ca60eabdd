// Mouse control of camera and hand in the scene view.
#pragma once

#include "app/layout.h"
#include "app/view/camera.h"
#include "engine/session/session.h"

#include <functional>

namespace springdrive::app {

/// Left drag moves the hand in the view plane, the wheel during a drag in depth; right drag orbits,
/// middle drag pans, the wheel zooms to the cursor. A drag belongs to the view in which it began.
class MouseInView {
public:
    /// @param may_move_hand  false while something else than the present is shown
    /// @param point_under    what is seen at a pixel of the view
    void apply(session::Session &session, Camera &camera, const Rectangle &view, bool may_move_hand,
               const std::function<Vector3(const PixelPoint &)> &point_under);

    [[nodiscard]] bool holds_hand() const { return dragging_ == Drag::hand; }

private:
    enum class Drag : unsigned char { none, hand, orbit, pan };

    Drag dragging_ = Drag::none;
    Vector3 grabbed_m_{Vector3::Zero()}; ///< position of the hand by the mouse, within reach or not
};

} // namespace springdrive::app
