#include "engine/study/methods/random_key.h"

#include "base/assertions.h"
#include "base/split_mix.h"
#include "engine/study/methods/psychometric_function.h"

#include <algorithm>
#include <limits>
#include <vector>

namespace springdrive::study {

// Scattered once more, so that children of neighbouring keys are no shifted copies of each other.
RandomKey child(RandomKey key, std::uint64_t number) {
    return {split_mix::scattered(split_mix::value(key.bits, number) ^ key.bits)};
}

RandomKey key_of(std::uint64_t seed, int participant) {
    return child(RandomKey{split_mix::value(seed, 0)}, static_cast<std::uint64_t>(participant));
}

double uniform(RandomKey key) { return split_mix::unit_share(split_mix::value(key.bits, 0)); }

double standard_normal(RandomKey key) {
    constexpr double kMin = 0x1p-54; // uniform() may be 0
    return core_argument(Shape::cumulative_normal, std::max(kMin, uniform(key)));
}

// The bias of the product, count/2^53, is far below what any study can see.
std::size_t below(RandomKey key, std::size_t count) {
    SPRINGDRIVE_ASSERT(count >= 1);
    return static_cast<std::size_t>(uniform(key) * static_cast<double>(count));
}

std::optional<std::size_t> next_turn(std::span<const Interleaved> all, RandomKey key) {
    int fewest = std::numeric_limits<int>::max();
    for (const Interleaved &one : all) {
        fewest = one.is_done ? fewest : std::min(fewest, one.trials);
    }
    std::vector<std::size_t> eligible;
    for (std::size_t i = 0; i < all.size(); ++i) {
        if (!all[i].is_done && all[i].trials - fewest < kMaxLead) {
            eligible.push_back(i);
        }
    }
    return eligible.empty() ? std::nullopt : std::optional(eligible[below(key, eligible.size())]);
}

} // namespace springdrive::study
