// The tunings in assets/tunings that have a button in the tuning panel.
#pragma once

#include <array>
#include <string>
#include <string_view>

namespace springdrive::app {

struct Preset {
    std::string_view label; ///< of its button; several may share one
    std::string_view file;  ///< in assets/tunings, without ending
    /// The lowest servo rate, without delay, at which it is meant to be used; 0: any servo.
    double min_servo_hz = 0.0;
};

/// Those of one label by rising servo rate.
inline constexpr std::array<Preset, 4> kPresets{{
    {"soft", "soft"},
    {"firm", "firm"},
    {"stiffest", "stiffest_1kHz", 1000.0},
    {"stiffest", "stiffest_4kHz", 4000.0},
}};

/// Their labels, one button each.
inline constexpr std::array<const char *, 3> kPresetLabels{"soft", "firm", "stiffest"};

/// The file of a button: of the highest rate that is not above the servo's. Empty where there is
/// none for this servo.
[[nodiscard]] std::string preset_file(std::string_view label, double servo_hz,
                                      double delay_periods);

} // namespace springdrive::app
