// Paths of a tip over a surface, without a hand: one position for each servo tick.
#pragma once

#include "base/vector.h"
#include "engine/contact/proxy/haptic_surface.h"

#include <Eigen/Geometry>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

namespace springdrive::rig {

enum class TouchPathKind : std::uint8_t {
    press,     ///< straight in from outside and out again, at many places
    slide,     ///< under the surface along great circles about the middle of its box
    lissajous, ///< under the surface along a curve that covers it, at varying depth
    rain,      ///< falls freely from above at random places, rests, and rises as it fell
    random,    ///< random walk in and around the box, with occasional jumps
};

struct TouchPathName {
    TouchPathKind kind;
    std::string_view name;
};
inline constexpr std::array<TouchPathName, 5> kTouchPathNames{
    {{TouchPathKind::press, "press"},
     {TouchPathKind::slide, "slide"},
     {TouchPathKind::lissajous, "lissajous"},
     {TouchPathKind::rain, "rain"},
     {TouchPathKind::random, "random"}}};

[[nodiscard]] std::optional<TouchPathKind> touch_path_named(std::string_view name);

struct TouchPathOptions {
    TouchPathKind kind = TouchPathKind::slide;
    std::size_t steps = 20'000;
    double period_s = 1e-3;
    double speed_m_per_s = 0.1; ///< of the tip, along its path; rain falls under gravity
    double depth_m = 1.5e-3;    ///< below the surface: how far beyond the first touch
    double radius_m = 0.0;      ///< of the proxy that probes the surface
    std::uint64_t seed = 1;
};

/// As many tips as steps are requested, the first in free space; the same for the same options.
///
/// Slide and lissajous follow the surface as seen from outside; hidden parts are not touched.
/// Where there is no surface on the way to the middle, the tip leaves and goes round outside.
/// @param box  what the surface lies in, not empty
[[nodiscard]] std::vector<Vector3> touch_path(const contact::HapticSurface &surface,
                                              const Eigen::AlignedBox3d &box,
                                              const TouchPathOptions &options);

} // namespace springdrive::rig
