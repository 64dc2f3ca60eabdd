// Covers engine/servo/servo_inputs.cpp.
#include "engine/servo/servo_inputs.h"

#include "engine/control/parameters.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <random>
#include <string>
#include <vector>

namespace springdrive::servo {
namespace {

const contact::HapticSurface kSurface;

ServoInputs any_inputs(std::mt19937_64 &random) {
    std::uniform_real_distribution<double> share(0.0, 1.0);
    ServoInputs inputs;
    for (const control::Parameter &parameter : control::kParameters) {
        inputs.tuning.*parameter.value =
            parameter.lowest + share(random) * (parameter.highest - parameter.lowest);
    }
    inputs.tuning.map = static_cast<control::MotionMap>(random() % 2);
    inputs.tuning.alpha_mode = static_cast<control::AlphaMode>(random() % 3);
    for (const SafetyLimit &limit : kSafetyLimits) {
        if (share(random) < 0.5) {
            inputs.limits.*limit.value = 10.0 * share(random);
        }
    }
    inputs.surface = share(random) < 0.5 ? &kSurface : nullptr;
    inputs.scene_id = static_cast<std::uint32_t>(random());
    inputs.global_alpha_rad2_per_m2 = 5000.0 * share(random);
    inputs.emergency_stop = share(random) < 0.5;
    inputs.reset_count = static_cast<std::uint32_t>(random());
    inputs.heartbeat = static_cast<std::uint32_t>(random());
    return inputs;
}

/// One bit of a set of inputs, by name, and how to flip it.
struct Bit {
    std::string name;
    std::function<void(ServoInputs &)> flip;
};

template <typename Integer> Integer flipped(Integer value, int bit) {
    return static_cast<Integer>(value ^ (Integer{1} << static_cast<unsigned>(bit)));
}

double flipped_double(double value, int bit) {
    return std::bit_cast<double>(flipped(std::bit_cast<std::uint64_t>(value), bit));
}

/// Every bit of every field; of a bool the one that it has, and of padding none.
std::vector<Bit> every_bit() {
    std::vector<Bit> bits;
    for (int bit = 0; bit < 64; ++bit) {
        for (const control::Parameter &p : control::kParameters) {
            bits.push_back({std::string(p.name), [bit, &p](ServoInputs &inputs) {
                                double &value = inputs.tuning.*p.value;
                                value = flipped_double(value, bit);
                            }});
        }
        for (const SafetyLimit &limit : kSafetyLimits) {
            bits.push_back({limit.name, [bit, &limit](ServoInputs &inputs) {
                                double &value = inputs.limits.*limit.value;
                                value = flipped_double(value, bit);
                            }});
        }
        bits.push_back({"surface", [bit](ServoInputs &inputs) {
                            inputs.surface = std::bit_cast<const contact::HapticSurface *>(
                                flipped(std::bit_cast<std::uintptr_t>(inputs.surface), bit));
                        }});
        bits.push_back({"global_alpha", [bit](ServoInputs &inputs) {
                            inputs.global_alpha_rad2_per_m2 =
                                flipped_double(inputs.global_alpha_rad2_per_m2, bit);
                        }});
    }
    for (int bit = 0; bit < 32; ++bit) {
        for (std::uint32_t ServoInputs::*field :
             {&ServoInputs::scene_id, &ServoInputs::reset_count, &ServoInputs::heartbeat,
              &ServoInputs::checksum}) {
            bits.push_back({"a number", [bit, field](ServoInputs &inputs) {
                                inputs.*field = flipped(inputs.*field, bit);
                            }});
        }
    }
    for (int bit = 0; bit < 8; ++bit) {
        bits.push_back({"map", [bit](ServoInputs &inputs) {
                            inputs.tuning.map = static_cast<control::MotionMap>(
                                flipped(static_cast<std::uint8_t>(inputs.tuning.map), bit));
                        }});
        bits.push_back({"alpha_mode", [bit](ServoInputs &inputs) {
                            inputs.tuning.alpha_mode = static_cast<control::AlphaMode>(
                                flipped(static_cast<std::uint8_t>(inputs.tuning.alpha_mode), bit));
                        }});
    }
    bits.push_back({"emergency_stop",
                    [](ServoInputs &inputs) { inputs.emergency_stop = !inputs.emergency_stop; }});
    bits.push_back({"release", [](ServoInputs &inputs) { inputs.release = !inputs.release; }});
    return bits;
}

TEST(ServoInputs, AreWholeOnceTheyAreSealed) {
    std::mt19937_64 random(7);
    EXPECT_TRUE(is_whole(sealed({})));
    EXPECT_FALSE(is_whole({}));
    for (int run = 0; run < 1000; ++run) {
        const ServoInputs inputs = any_inputs(random);
        EXPECT_TRUE(is_whole(sealed(inputs)));
        EXPECT_TRUE(is_whole(sealed(sealed(inputs)))); // sealing twice is sealing once
        EXPECT_EQ(sealed(inputs).checksum, sealed(sealed(inputs)).checksum);
    }
}

TEST(ServoInputs, SealingChangesNothingElse) {
    std::mt19937_64 random(8);
    const ServoInputs inputs = any_inputs(random);
    const ServoInputs same = sealed(inputs);
    for (const control::Parameter &parameter : control::kParameters) {
        EXPECT_EQ(same.tuning.*parameter.value, inputs.tuning.*parameter.value);
    }
    for (const SafetyLimit &limit : kSafetyLimits) {
        EXPECT_EQ(same.limits.*limit.value, inputs.limits.*limit.value);
    }
    EXPECT_EQ(same.surface, inputs.surface);
    EXPECT_EQ(same.reset_count, inputs.reset_count);
    EXPECT_EQ(same.emergency_stop, inputs.emergency_stop);
}

TEST(ServoInputs, AnySingleBitThatIsFlippedIsNoticed) {
    std::mt19937_64 random(9);
    const std::vector<Bit> bits = every_bit();
    EXPECT_EQ(bits.size(), 64U * (6 + 10 + 2) + 32U * 4 + 8U * 2 + 2);
    for (int run = 0; run < 200; ++run) {
        const ServoInputs whole = sealed(run == 0 ? ServoInputs{} : any_inputs(random));
        for (const Bit &bit : bits) {
            ServoInputs torn = whole;
            bit.flip(torn);
            ASSERT_FALSE(is_whole(torn)) << bit.name;
            bit.flip(torn);
            ASSERT_TRUE(is_whole(torn)) << bit.name;
        }
    }
}

TEST(ServoInputs, HalfOfOneAndHalfOfAnotherIsNoticed) {
    // As a copy that was overtaken would be: the first words of one, the rest of another.
    std::mt19937_64 random(10);
    using Words = std::array<unsigned char, sizeof(ServoInputs)>;
    for (int run = 0; run < 500; ++run) {
        const ServoInputs one = sealed(any_inputs(random));
        const ServoInputs other = sealed(any_inputs(random));
        const auto first = std::bit_cast<Words>(one);
        for (std::size_t cut = 8; cut < sizeof(ServoInputs); cut += 8) {
            auto mixed = std::bit_cast<Words>(other);
            std::copy_n(first.begin(), cut, mixed.begin());
            const auto torn = std::bit_cast<ServoInputs>(mixed);
            const bool same = torn.checksum == one.checksum && torn.heartbeat == one.heartbeat;
            ASSERT_EQ(is_whole(torn), same) << cut;
        }
    }
}

} // namespace
} // namespace springdrive::servo
