// What a stimulus is measured by: the same of what was intended and of what was delivered.
#pragma once

#include <array>
#include <optional>
#include <string_view>

namespace springdrive::study {

/// Nothing where it does not apply, or could not be measured.
struct StimulusMeasures {
    std::optional<double> turn_deg;          ///< of the force, or of a pulse; see `ForceAngles`
    std::optional<double> across_deg;        ///< the same
    std::optional<double> stiffness_N_per_m; ///< along the normal, at rest
    std::optional<double> press_N;           ///< of the hand along the normal, at rest
    std::optional<double> speed_m_per_s;     ///< of the hand: at touch, or at most in a stroke
    std::optional<double> pulse_N;           ///< height of a pulse, on a hand that does not move

    friend bool operator==(const StimulusMeasures &, const StimulusMeasures &) = default;
};

struct StimulusMeasure {
    std::string_view name; ///< in stores and exports, with its unit
    std::optional<double> StimulusMeasures::*value = nullptr;
};

/// The list of all, in the order in which they are stored.
inline constexpr std::array<StimulusMeasure, 6> kStimulusMeasures{{
    {"direction_deg", &StimulusMeasures::turn_deg},
    {"direction_across_deg", &StimulusMeasures::across_deg},
    {"stiffness_N_per_m", &StimulusMeasures::stiffness_N_per_m},
    {"press_N", &StimulusMeasures::press_N},
    {"speed_m_per_s", &StimulusMeasures::speed_m_per_s},
    {"pulse_N", &StimulusMeasures::pulse_N},
}};

} // namespace springdrive::study
