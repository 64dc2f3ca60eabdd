// The state that the 3-D view shows: what of the touch is drawn, the list that legend, drawing and
// settings share; and the scales that the view shares with panels and legends.
#pragma once

#include "app/view/solids.h"
#include "base/vector.h"
#include "device/core/device_description.h"
#include "device/core/phantom/kinematics.h"

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace springdrive::app {

enum class Thing : std::uint8_t {
    tip,
    height,
    hand,
    proxy,
    normal,
    force,
    both_forces,
    contact_plane,
    set_point,
    stiffness,
    trace,
    direction_errors,
    stiffnesses,
};

// Distinguishable with any colour vision deficiency (after Okabe and Ito), also on dark panels.
inline constexpr Colour kTipColour{0.92F, 0.38F, 0.05F};
inline constexpr Colour kProxyColour{0.34F, 0.71F, 0.91F};
inline constexpr Colour kForceColour{1.0F, 0.86F, 0.16F};
inline constexpr Colour kNormalColour{0.20F, 0.86F, 0.62F};
inline constexpr Colour kHandColour{1.0F, 0.50F, 0.80F};
inline constexpr Colour kSetPointColour{0.80F, 0.68F, 1.0F};
// As in the plots.
inline constexpr Colour kTransposeColour{0.36F, 0.73F, 0.95F};
inline constexpr Colour kInverseColour{1.0F, 0.52F, 0.32F};

struct OverlayStyle {
    Thing thing{};
    const char *word = "";  ///< in the file of settings
    const char *label = ""; ///< in the legend
    const char *help = "";
    Colour colour{};
    Colour second{}; ///< of its other part, or the end of its scale; else the same
    bool is_scale = false;
    bool is_on_at_first = false;
};

/// Violet over teal to yellow: told apart by brightness alone, too.
inline constexpr std::array<Colour, 4> kScaleColours{
    {{0.42F, 0.32F, 0.78F}, {0.18F, 0.56F, 0.68F}, {0.34F, 0.80F, 0.52F}, {0.99F, 0.90F, 0.20F}}};

/// The colour at a share from 0 to 1 of a scale.
[[nodiscard]] constexpr Colour scale_colour(double share) {
    const double within = share < 0.0 ? 0.0 : share > 1.0 ? 1.0 : share; // also of NaN: 1
    const double place = within * (kScaleColours.size() - 1);
    const auto first = place >= kScaleColours.size() - 1 ? kScaleColours.size() - 2
                                                         : static_cast<std::size_t>(place);
    const auto rest = static_cast<float>(place - static_cast<double>(first));
    Colour mixed{};
    for (std::size_t i = 0; i < mixed.size(); ++i) {
        mixed[i] = (1.0F - rest) * kScaleColours[first][i] + rest * kScaleColours[first + 1][i];
    }
    return mixed;
}

/// In the order of the legend, which is that of `Thing`.
inline constexpr std::array<OverlayStyle, 13> kThings{{
    {Thing::tip, "tip", "tip", "The device's tip; in a ring where the scene hides it.", kTipColour,
     kTipColour, false, true},
    {Thing::height, "height", "height", "From the tip straight down to what is below it.",
     kTipColour, kTipColour, false, true},
    {Thing::hand, "hand", "hand", "Where the simulated hand pulls to.", kHandColour, kHandColour,
     false, true},
    {Thing::proxy, "proxy", "proxy",
     "The point of the surface from which the tip is pulled, while it touches.", kProxyColour,
     kProxyColour, false, true},
    {Thing::normal, "normal", "normal", "Of the surface at the proxy.", kNormalColour,
     kNormalColour, false, true},
    {Thing::force, "force", "force", "On the hand, as measured by the currents: 15 mm for 1 N.",
     kForceColour, kForceColour, false, true},
    {Thing::both_forces, "both_forces", "forces of both maps",
     "What J^T control (blue) and J\u207b\u00b9 control (orange) would each push with at rest, "
     "here "
     "and now,\nin the scale of the force.",
     kTransposeColour, kInverseColour},
    {Thing::contact_plane, "contact_plane", "contact plane",
     "The plane in which the proxy may slide.", kNormalColour, kNormalColour},
    {Thing::set_point, "set_point", "set-point",
     "x_Sd (30): at the proxy for \u03b7 0, nearer to the tip where the surface is soft.",
     kSetPointColour, kSetPointColour},
    {Thing::stiffness, "stiffness", "stiffness at the tip",
     "Figure 3 of the paper, here and now: force per displacement in each direction. The sphere "
     "of\nJ^T control (blue), the ellipsoid of J\u207b\u00b9 control (orange): 10 mm for 1 N/mm, "
     "smaller where\nit would exceed 60 mm.",
     kTransposeColour, kInverseColour},
    {Thing::trace, "trace", "trace of 5 s", "Where the tip was, coloured by the force.",
     kScaleColours.front(), kScaleColours.back(), true},
    {Thing::direction_errors, "direction_errors", "direction errors",
     "Over the workspace: the largest angle between normal and push with J\u207b\u00b9 control, of "
     "all normals.",
     kScaleColours.front(), kScaleColours.back(), true},
    {Thing::stiffnesses, "stiffnesses", "stiffnesses",
     "Over the workspace: the stiffness with J^T control, with \u03b1 at its bound (29).",
     kScaleColours.front(), kScaleColours.back(), true},
}};

/// Which of them are drawn.
class ShownThings {
public:
    ShownThings() {
        for (const OverlayStyle &look : kThings) {
            show(look.thing, look.is_on_at_first);
        }
    }

    [[nodiscard]] bool shows(Thing thing) const { return on_[static_cast<std::size_t>(thing)]; }

    /// Of the two that colour the workspace, one at most.
    void show(Thing thing, bool on) {
        if (on && (thing == Thing::direction_errors || thing == Thing::stiffnesses)) {
            on_.reset(static_cast<std::size_t>(Thing::direction_errors));
            on_.reset(static_cast<std::size_t>(Thing::stiffnesses));
        }
        on_.set(static_cast<std::size_t>(thing), on);
    }

    friend bool operator==(const ShownThings &, const ShownThings &) = default;

private:
    std::bitset<kThings.size()> on_;
};

/// A place with a quantity there.
struct PlacedValue {
    Vector3 at_m{Vector3::Zero()};
    double value = 0.0;
};

/// A quantity all over the workspace.
struct WorkspaceField {
    std::vector<PlacedValue> places;
    double largest = 0.0; ///< of them
};

/// Each is there only if it is to be drawn.
struct TouchValues {
    std::optional<Vector3> inverse_force_N;
    std::optional<Vector3> transpose_force_N;
    std::optional<Vector3> set_point_m;
    std::optional<Matrix3> inverse_stiffness_N_per_m;
    std::optional<double> transpose_stiffness_N_per_m;
    std::vector<PlacedValue> trace_N; ///< the oldest first
    std::shared_ptr<const WorkspaceField> workspace;
};

/// The force at which the trace's colour ends.
inline constexpr double kTraceEnd_N = 3.0;

/// A point of a surface.
struct SurfacePlace {
    Vector3 point_m{Vector3::Zero()};
    Vector3 normal{Vector3::UnitY()}; ///< unit, towards the side from which it is met
};

inline constexpr double kArrowMetresPerNewton = 0.015; ///< 2 N are 30 mm

/// Of the arrows of forces; larger where they are seen from afar.
struct ArrowSize {
    double m_per_N = kArrowMetresPerNewton;
    double thickness = 1.0; ///< times the usual one
};

/// World coordinates are those of the device frame.
struct ViewState {
    device::LinkagePose linkage;
    Vector3 tip_m{Vector3::Zero()};
    Vector3 proxy_m{Vector3::Zero()};       ///< drawn during contact
    Vector3 normal{Vector3::Zero()};        ///< unit, of the surface under the proxy, if touching
    Vector3 tip_force_N{Vector3::Zero()};   ///< rendered
    Vector3 hand_target_m{Vector3::Zero()}; ///< set by the mouse
    bool touching = false;
    bool hand_held = false; ///< the target is drawn brighter while the mouse holds it
    bool tripped = false;   ///< the safety monitor stopped the device: the linkage turns red
    device::Workspace workspace;
    double floor_height_m = 0.0;
    std::optional<SurfacePlace> below; ///< straight below the tip, or the proxy: surface or floor
    ShownThings shown;                 ///< what of all this is drawn
    TouchValues touch;
    ArrowSize arrow;
};

inline constexpr double kTipRadius_m = 2.0e-3;
inline constexpr double kProxyRadius_m = 2.5e-3;

} // namespace springdrive::app
