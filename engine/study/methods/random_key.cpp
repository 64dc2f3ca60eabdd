#include "engine/study/methods/random_key.h"

#include "base/assertions.h"

namespace springdrive::study {

namespace {

/// The finaliser of SplitMix64 (Steele, Lea & Flood 2014): a bijection that scatters every bit.
std::uint64_t scattered(std::uint64_t bits) {
    bits = (bits ^ (bits >> 30U)) * 0xbf58476d1ce4e5b9U;
    bits = (bits ^ (bits >> 27U)) * 0x94d049bb133111ebU;
    return bits ^ (bits >> 31U);
}

constexpr std::uint64_t kGoldenGamma = 0x9e3779b97f4a7c15U;

} // namespace

// Value number + 1 of the generator SplitMix64 that starts at the key, scattered once more, so that
// children of neighbouring keys are no shifted copies of each other.
RandomKey child(RandomKey key, std::uint64_t number) {
    return {scattered(scattered(key.bits + (number + 1U) * kGoldenGamma) ^ key.bits)};
}

RandomKey key_of(std::uint64_t seed, int participant) {
    return child(RandomKey{scattered(seed + kGoldenGamma)},
                 static_cast<std::uint64_t>(participant));
}

double uniform(RandomKey key) {
    return static_cast<double>(scattered(key.bits + kGoldenGamma) >> 11U) * 0x1p-53;
}

// The bias of the product, count/2^53, is far below what any study can see.
std::size_t below(RandomKey key, std::size_t count) {
    SPRINGDRIVE_ASSERT(count >= 1);
    return static_cast<std::size_t>(uniform(key) * static_cast<double>(count));
}

} // namespace springdrive::study
