// Everything that a protocol can present, condition by condition and level by level.
#pragma once

#include "engine/study/protocol/study_setting.h"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace springdrive::study {

/// A comparison at a level, or a standard.
struct Presented {
    std::size_t condition = 0;   ///< index into `Protocol::conditions`
    std::optional<double> level; ///< nothing: the standard
    Condition parameters;
    control::Tuning free_space; ///< in force before and after; its η is that of contact
    int target = 0;             ///< of a forced choice by place, from 0
};

/// Of every condition in use, the standard and the comparison at all `presentable_levels`.
/// Conditions that are in no block and no standard are left out; so are those that cannot be in
/// free space as the protocol wants it.
[[nodiscard]] std::vector<Presented> all_presented(const Protocol &protocol);

/// Of each condition only the standard and the comparisons at the lowest and highest level.
[[nodiscard]] std::vector<Presented> extremes(const std::vector<Presented> &all);

/// "condition \"soft\" at level 0.9 (eta 0.9)".
[[nodiscard]] std::string name_of(const Protocol &protocol, const Presented &presented);

/// Whether a condition is in a block or the standard.
[[nodiscard]] bool is_used(const Protocol &protocol, std::size_t condition);

} // namespace springdrive::study
