// The state that the 3-D view shows, and the scales that it shares with panels and legends.
#pragma once

#include "app/view/shown_things.h"
#include "app/view/solids.h"
#include "app/view/touch_values.h"
#include "device/core/device_description.h"
#include "device/core/phantom/kinematics.h"

#include <optional>

namespace springdrive::app {

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
