// What a kiosk's screen shows over the scene: large words, few buttons, and the read-outs at the
// arrow. All sizes are shares of the picture's size, so that they are legible at a distance
// whatever the screen's pixels.
//
// The rule: digits are at least 6.5 % of the picture's height. On a screen 27 cm high (22 inches)
// or higher that is 17.5 mm: half a degree at two metres.
#pragma once

#include "app/exhibit/course.h"
#include "app/exhibit/trip_recovery.h"
#include "app/view/camera.h"
#include "app/view/view_state.h"
#include "app/widgets/rectangle.h"
#include "app/window/window.h"
#include "engine/control/tuning.h"

#include <optional>
#include <string>

namespace springdrive::app::exhibit {

/// Of the force's arrow, which has to be seen at a distance too: 1 N is 60 mm.
inline constexpr ArrowSize kArrow{4.0 * kArrowMetresPerNewton, 2.0};

struct KioskReadOut {
    double force_N = 0.0;
    std::optional<double> angle_rad; ///< from the surface's normal to the push
    Vector3 arrow_from_m{Vector3::Zero()};
    Vector3 arrow_m{Vector3::Zero()}; ///< end of the force's arrow
};

struct KioskShown {
    const Course &course;
    const TripRecovery &recovery;
    bool has_script = true; ///< a scripted hand shows the scene
    std::string title{};
    std::string sentence{};
    std::string stop{}; ///< what stopped it; else empty
    control::MotionMap map = control::MotionMap::transpose;
    std::optional<KioskReadOut> read_out{}; ///< in contact
};

/// Buttons that were pressed.
struct KioskAnswer {
    bool my_turn = false;
    bool other_map = false;
    bool next_scene = false;
    bool next_visitor = false;
    bool stop = false;
    bool go_on = false;
};

[[nodiscard]] KioskAnswer draw_kiosk(const KioskShown &shown, const Camera &camera,
                                     const Rectangle &view, const Window::LargeText &text);

/// The part of the view that none of the fixed words cover.
[[nodiscard]] Rectangle free_in_kiosk(const Rectangle &view);

} // namespace springdrive::app::exhibit
