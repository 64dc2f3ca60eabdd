// Judges a record of a servo whose scene, rate or device was exchanged: from its samples alone,
// with the law asked anew.
#pragma once

#include "engine/control/haptic_law.h"
#include "engine/servo/servo_sample.h"

#include <cstdint>
#include <filesystem>
#include <string>

namespace springdrive::testing {

/// What a record has shown. Steps are those that changes made, beside what the motion gives.
struct JudgedRecord {
    std::uint64_t rows = 0;
    std::uint64_t felt = 0;          ///< with voltage on and the tip touching
    std::uint64_t scenes = 0;        ///< that came into force while voltage was on
    std::uint64_t rates = 0;         ///< the same
    double greatest_share = 0.0;     ///< of a step of e_W in the one that is allowed
    double greatest_step_V = 0.0;    ///< of e_W
    double greatest_carried_V = 0.0; ///< what was not let through at once: not vacuous
    bool replays = false;            ///< equal to the last bit
    std::string first_fault;         ///< empty: none
};

/// Every row follows the one before, in tick, time and measurement; nothing tripped; no change
/// moved e_W by more than kGreatestChange_V_per_s · T and what the ramp gives; and the replay is
/// equal to the last bit.
[[nodiscard]] JudgedRecord judge_record(const std::filesystem::path &file);

} // namespace springdrive::testing
