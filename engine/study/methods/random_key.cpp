#include "engine/study/methods/random_key.h"

#include "base/assertions.h"
#include "base/split_mix.h"
#include "engine/study/methods/psychometric_function.h"

#include <algorithm>

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

} // namespace springdrive::study
