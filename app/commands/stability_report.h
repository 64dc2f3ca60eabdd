// The report of `springdrive stability`, as text or JSON.
#pragma once

#include "engine/lab/limits/stability_limits.h"

#include <optional>
#include <ostream>
#include <vector>

namespace springdrive::app {

struct StabilityReport {
    loops::StabilityCase which;
    loops::WorstMember worst;
    bool stable_simulated = true; ///< with counts and supply
    const loops::StabilityParameter *varied = nullptr;
    limits::ParameterRange range;
    std::vector<limits::StabilityLimit> limits;
    /// By the prediction; nothing if there are limits, or no parameter varies.
    std::optional<bool> stable_throughout;

    /// By both.
    [[nodiscard]] bool is_stable() const { return worst.is_stable() && stable_simulated; }
};

void write_stability_table(std::ostream &out, const StabilityReport &report);

/// One object; missing values are null.
void write_stability_json(std::ostream &out, const StabilityReport &report);

/// Colgate and Schenkel's limit K = 2b/T, for a delay of d periods and an amplifier of bandwidth ω:
/// 2b/(T(1 + 2d) + 2/ω), for a motor of a current drive without a hand and without B; the minimum
/// over all motors [N/m at the tip].
[[nodiscard]] double passive_wall_N_per_m(const loops::StabilityCase &which);

} // namespace springdrive::app
