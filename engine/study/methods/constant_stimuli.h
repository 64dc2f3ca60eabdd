// The method of constant stimuli: every level as often as every other, in an order by chance.
#pragma once

#include <string>
#include <vector>

namespace springdrive::study {

/// `blocks` times a random order of `repetitions` presentations of each level: a drift in time
/// reaches all levels alike, to within a block.
struct ConstantStimuli {
    std::vector<double> levels; ///< rising
    int repetitions = 1;        ///< of each level in one block
    int blocks = 20;

    friend bool operator==(const ConstantStimuli &, const ConstantStimuli &) = default;
};

/// Empty if the method can be used; else the first bad key, with value and range.
[[nodiscard]] std::string what_is_wrong_with(const ConstantStimuli &method);

} // namespace springdrive::study
