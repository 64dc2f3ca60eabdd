// Whether a stimulus was what it was to be.
#pragma once

#include "engine/study/protocol/protocol.h"
#include "engine/study/store/study_contents.h"

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::study {

/// What a stimulus is measured by, and how far it may be off. In stores and exports by its name.
enum class Band : std::uint8_t {
    direction, ///< difference from the intended angle, at most `Marking::direction_deg`
    stiffness, ///< share of the intended one, at most `Marking::stiffness_percent`
    force,     ///< share of the intended one, at most `Marking::force_percent`
    lateness,  ///< at most `Marking::lateness_s`
};

struct MeasuredValue {
    std::string_view name; ///< of `StimulusValue`, with its unit
    Band band;
};

inline constexpr std::array<MeasuredValue, 7> kMeasuredValues{{
    {"direction_deg", Band::direction},
    {"direction_across_deg", Band::direction}, ///< out of the plane of the turn
    {"stiffness_N_per_m", Band::stiffness},
    {"press_N", Band::force},
    {"speed_m_per_s", Band::force},
    {"pulse_N", Band::force},
    {"lateness_s", Band::lateness},
}};

/// Why a trial does not count, a line for each value out of its band: outside, or intended and not
/// measured. Empty: it counts. Values with other names have no band.
[[nodiscard]] std::vector<std::string> marks_of(const Marking &marking,
                                                std::span<const Presentation> presentations);

/// Whether a trial with these marks is presented again. Without an answer a method has nothing to
/// learn from, whatever the protocol says of repeating.
[[nodiscard]] bool comes_again(const Marking &marking, const std::vector<std::string> &marks,
                               const Response &response);

} // namespace springdrive::study
