#include "app/view/touch_marks.h"

#include <algorithm>

namespace springdrive::app {

namespace {

constexpr double kMinHeight_m = 1.0e-3; // shorter lines would hide in the tip
constexpr double kHeightLine_px = 0.7;  // its radius
constexpr double kFoot_m = 3.5e-3;      // radius of the ring
constexpr double kFoot_px = 5.0;
constexpr double kOffTheGround_m = 4.0e-4; // of the foot, which would flicker in the surface

constexpr double kGhostPerTip = 1.8; // radius
constexpr double kGhost_px = 6.5;

} // namespace

std::vector<Solid> height_line(const ViewState &state, const MarkerScale &scale) {
    const Vector3 &top_m = state.touching ? state.proxy_m : state.tip_m;
    if (!state.shown.shows(Thing::height) || !state.below ||
        !((top_m - state.below->point_m).norm() > kMinHeight_m)) {
        return {};
    }
    const auto &[foot_m, normal] = *state.below;
    const double foot_radius_m = std::max(kFoot_m, scale.length_m(kFoot_px, foot_m));
    return {
        spindle(Shape::cylinder, top_m, foot_m, scale.length_m(kHeightLine_px, foot_m), kTipColour),
        ring(foot_m + kOffTheGround_m * normal, normal, foot_radius_m, kTipColour)};
}

TipMarks tip_marks(const ViewState &state, const MarkerScale &scale) {
    if (!state.shown.shows(Thing::tip)) {
        return {};
    }
    const double min_m = scale.length_m(kGhost_px, state.tip_m);
    return {{tip_solid(state, scale)},
            {ring(state.tip_m, scale.camera.forward(), std::max(kGhostPerTip * kTipRadius_m, min_m),
                  kTipColour)}};
}

} // namespace springdrive::app
