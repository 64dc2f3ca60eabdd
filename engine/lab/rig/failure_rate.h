// What a number of trials says of the rate of rare failures.
#pragma once

#include <cstddef>

namespace springdrive::rig {

/// The trials, without any failure, after which a rate of failures is excluded:
/// (1 − rate)ⁿ <= 1 − confidence, about 3 / rate at 95 %.
/// @pre both lie between 0 and 1
[[nodiscard]] std::size_t trials_to_exclude(double rate, double confidence);

/// The rate that is not excluded: with a greater one, as few failures as these would be found with
/// a probability of at most 1 − confidence. The upper limit of Clopper and Pearson (1934).
/// @pre failures <= trials; confidence between 0 and 1
[[nodiscard]] double rate_not_excluded(std::size_t failures, std::size_t trials, double confidence);

} // namespace springdrive::rig
