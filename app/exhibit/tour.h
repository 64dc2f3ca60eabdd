// The tour of an exhibit: its scenes in their order, and how a scripted hand shows each.
#pragma once

#include "device/core/device_description.h"
#include "device/simulated/hand_path.h"
#include "engine/contact/proxy/haptic_surface.h"
#include "engine/scene/scene.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::app::exhibit {

enum class Gesture : std::uint8_t {
    stroke,     ///< presses, and strokes to and fro
    strike,     ///< blows from above
    press_each, ///< presses on each part that has a caption
    compare,    ///< presses on the lesson's spot, with one map and with the other
};

struct TourStop {
    std::string_view scene; ///< name of the file in assets/scenes, without its ending
    Gesture gesture = Gesture::stroke;
    std::string_view
        sentence{}; ///< in place of the scene's own, if that speaks of panels or symbols
};

/// All scenes that are included.
inline constexpr std::array<TourStop, 11> kTour{{
    {"plate", Gesture::stroke},
    {"wrong_direction", Gesture::compare,
     "Press on the orange square, then switch the map: one pushes square to the surface, the other "
     "far to the side."},
    {"slope", Gesture::stroke},
    {"compliance", Gesture::press_each},
    {"organic", Gesture::stroke},
    {"stepped_block", Gesture::stroke},
    {"thin_plate", Gesture::stroke},
    {"spheres", Gesture::press_each},
    {"profile", Gesture::stroke},
    {"sphere", Gesture::stroke},
    {"blow", Gesture::strike},
}};

[[nodiscard]] std::filesystem::path file_of(const TourStop &stop);

/// The stop's sentence, or else the scene's.
[[nodiscard]] std::string sentence_of(const TourStop &stop, const scene::Scene &scene);

/// What the scripted hand does.
struct Showing {
    simulated::HandPath path;
    std::vector<double> switches_s; ///< times of the path at which the map is switched
};

// Speeds of the scripted hand's target.
inline constexpr double kTransit_m_per_s = 0.08;
inline constexpr double kPress_m_per_s = 0.03;
inline constexpr double kStroke_m_per_s = 0.04;
inline constexpr double kStrike_m_per_s = 0.20;

/// From where the hand is, out of anything it is below, to the scene, and back to above it.
/// @return nothing where the device does not reach all of it
[[nodiscard]] std::optional<Showing> showing_of(const device::DeviceDescription &device,
                                                const scene::Scene &scene,
                                                const contact::HapticSurface &surface,
                                                Gesture gesture, const Vector3 &from_m);

} // namespace springdrive::app::exhibit
