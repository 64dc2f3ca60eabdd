// What a planned trial presents, one after the other.
#pragma once

#include "engine/study/conduct/sequence.h"
#include "engine/study/protocol/presented.h"

#include <vector>

namespace springdrive::study {

struct Interval {
    Presented presented;
    bool is_comparison = false;
    int target = 0; ///< of a forced choice by place
};

/// In their order. @pre what_is_wrong_with(protocol) is empty
[[nodiscard]] std::vector<Interval> intervals_of(const Protocol &protocol,
                                                 const PlannedTrial &planned);

/// The comparison alone, at another level than the planned one: of an adjustment.
[[nodiscard]] Interval comparison_at(const Protocol &protocol, const PlannedTrial &planned,
                                     double level);

} // namespace springdrive::study
