#include "engine/study/methods/turns.h"

#include <algorithm>
#include <limits>
#include <vector>

namespace springdrive::study {

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
