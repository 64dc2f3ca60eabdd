// Checks a record of a servo whose scene, rate or device was exchanged: from its samples alone, by
// evaluating the law again.
#pragma once

#include "engine/control/haptic_law.h"
#include "engine/servo/servo_sample.h"

#include <cstdint>
#include <filesystem>
#include <string>

namespace springdrive::testing {

/// Results for a record. Steps are those caused by changes, not by motion.
struct JudgedRecord {
    std::uint64_t rows = 0;
    std::uint64_t felt = 0;             ///< with voltage on and the tip touching
    std::uint64_t scenes = 0;           ///< that became active while voltage was on
    std::uint64_t rates = 0;            ///< the same
    double max_share = 0.0;             ///< of a step of e_W relative to the allowed one
    double max_step_V = 0.0;            ///< of e_W
    double max_transfer_offset_V = 0.0; ///< offset of bumpless transfer: not vacuous
    bool replays = false;               ///< identical bit for bit
    std::string first_fault;            ///< empty if none
};

/// Every row follows the previous one in tick, time and measurement; there is no trip; no change
/// moved e_W by more than kMaxChange_V_per_s · T plus the ramp; and the replay is identical
/// bit for bit.
[[nodiscard]] JudgedRecord judge_record(const std::filesystem::path &file);

} // namespace springdrive::testing
