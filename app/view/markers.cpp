#include "app/view/markers.h"

#include <algorithm>

namespace springdrive::app {

namespace {

constexpr double kMinForce_N = 0.05; // shorter arrows would be noise
constexpr double kNormalLength_m = 0.060;
constexpr double kNormalBeyondArrow_m = 0.015;
constexpr double kDash_m = 0.0040;
constexpr double kGap_m = 0.0025;

// Minimum sizes, in layout pixels.
constexpr double kTipRadius_px = 4.0;
constexpr double kProxyRadius_px = 5.0;
constexpr double kShaftRadius_px = 2.0;
constexpr double kLineRadius_px = 0.9;
constexpr double kTargetRadius_px = 10.0;
constexpr double kLightTarget = 0.55; // of the hand colour while the hand is not held

constexpr double kShaftRadius_m =
    2.6e-3;                           // more than the forearm's near the tip, which it may hide in
constexpr double kHeadPerShaft = 2.2; // radius of the arrow's head
constexpr double kHeadSlenderness = 2.8;

void append_line(std::vector<Solid> &solids, const Vector3 &from_m, const Vector3 &to_m,
                 const Colour &colour, const MarkerScale &scale) {
    if (from_m != to_m) {
        solids.push_back(
            spindle(Shape::cylinder, from_m, to_m, scale.length_m(kLineRadius_px, from_m), colour));
    }
}

void append_arrow(std::vector<Solid> &solids, const Vector3 &from_m, const Vector3 &along_m,
                  double thickness, const MarkerScale &scale) {
    const double shaft_m =
        thickness * std::max(kShaftRadius_m, scale.length_m(kShaftRadius_px, from_m));
    const double length_m = along_m.norm();
    const double head_m = std::min(kHeadSlenderness * kHeadPerShaft * shaft_m, 0.6 * length_m);
    const Vector3 neck_m = from_m + (1.0 - head_m / length_m) * along_m;
    solids.push_back(spindle(Shape::cylinder, from_m, neck_m, shaft_m, kForceColour));
    solids.push_back(
        spindle(Shape::cone, neck_m, from_m + along_m, kHeadPerShaft * shaft_m, kForceColour));
}

void append_normal(std::vector<Solid> &solids, const ViewState &state, double arrow_m,
                   const MarkerScale &scale) {
    const double end_m = std::max(kNormalLength_m, arrow_m + kNormalBeyondArrow_m);
    for (double at_m = 0.0; at_m + kDash_m < end_m; at_m += kDash_m + kGap_m) {
        append_line(solids, state.proxy_m + at_m * state.normal,
                    state.proxy_m + (at_m + kDash_m) * state.normal, kNormalColour, scale);
    }
}

void append_hand_target(std::vector<Solid> &solids, const ViewState &state,
                        const MarkerScale &scale) {
    Colour colour = kHandColour;
    if (!state.hand_held) {
        for (float &channel : colour) {
            channel *= static_cast<float>(kLightTarget);
        }
    }
    const Vector3 &centre_m = state.hand_target_m;
    const double radius_m = scale.length_m(kTargetRadius_px, centre_m);
    solids.push_back(ring(centre_m, scale.camera.forward(), radius_m, colour));
    for (const Vector3 &arm : {scale.camera.right(), scale.camera.up()}) {
        for (const double side : {-1.0, 1.0}) {
            append_line(solids, centre_m + side * 0.65 * radius_m * arm,
                        centre_m + side * 1.45 * radius_m * arm, colour, scale);
        }
    }
}

constexpr double kMinHeight_m = 1.0e-3; // shorter lines would hide in the tip
constexpr double kHeightLine_px = 0.7;  // its radius
constexpr double kFoot_m = 3.5e-3;      // radius of the ring
constexpr double kFoot_px = 5.0;
constexpr double kOffTheGround_m = 4.0e-4; // of the foot, which would flicker in the surface

constexpr double kGhostPerTip = 1.8; // radius
constexpr double kGhost_px = 6.5;

} // namespace

std::vector<Solid> marker_solids(const ViewState &state, const MarkerScale &scale) {
    std::vector<Solid> solids;
    // A force that is not finite draws no arrow.
    const bool has_force = state.tip_force_N.allFinite() && state.tip_force_N.norm() > kMinForce_N;
    const Vector3 arrow_m =
        has_force ? Vector3(state.arrow.m_per_N * state.tip_force_N) : Vector3::Zero();
    if (state.touching && state.shown.shows(Thing::proxy)) {
        const double min_m = scale.length_m(kProxyRadius_px, state.proxy_m);
        solids.push_back(ball(state.proxy_m, std::max(kProxyRadius_m, min_m), kProxyColour));
        append_line(solids, state.proxy_m, state.tip_m, kTipColour, scale);
    }
    if (state.touching && state.shown.shows(Thing::normal)) {
        append_normal(solids, state, arrow_m.norm(), scale);
    }
    if (has_force && state.shown.shows(Thing::force)) {
        append_arrow(solids, state.touching ? state.proxy_m : state.tip_m, arrow_m,
                     state.arrow.thickness, scale);
    }
    if (state.shown.shows(Thing::hand)) {
        append_hand_target(solids, state, scale);
    }
    return solids;
}

Solid tip_solid(const ViewState &state, const MarkerScale &scale) {
    const double min_m = scale.length_m(kTipRadius_px, state.tip_m);
    return ball(state.tip_m, std::max(kTipRadius_m, min_m), kTipColour);
}

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
