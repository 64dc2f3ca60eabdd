// Covers passing engine/servo/servo_inputs.h through base/latest_value.h: inputs with a checksum of
// every field arrive intact, however quickly one thread publishes and the other reads.
#include "engine/servo/servo_inputs.h"

#include "base/latest_value.h"
#include "engine/control/tuning.h"

#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <functional>
#include <random>
#include <string>
#include <thread>
#include <vector>

namespace springdrive::servo {
namespace {

/// FNV-1a over words: every field counts.
class Mix {
public:
    void add(std::uint64_t word) {
        for (; word != 0; word >>= 32U) {
            hash_ = (hash_ ^ (word & 0xffffffffU)) * 0x100000001b3U;
        }
        hash_ = (hash_ ^ 0x9eU) * 0x100000001b3U; // so that zeros and word boundaries count
    }
    void add(double value) { add(std::bit_cast<std::uint64_t>(value)); }
    [[nodiscard]] std::uint32_t sum() const {
        return static_cast<std::uint32_t>(hash_ ^ (hash_ >> 32U));
    }

private:
    std::uint64_t hash_ = 0xcbf29ce484222325U;
};

std::uint32_t checksum(const ServoInputs &inputs) {
    Mix mix;
    for (const control::Parameter &parameter : control::kParameters) {
        mix.add(inputs.tuning.*parameter.value);
    }
    mix.add(static_cast<std::uint64_t>(inputs.tuning.map));
    mix.add(static_cast<std::uint64_t>(inputs.tuning.alpha_mode));
    for (const SafetyLimit &limit : kSafetyLimits) {
        mix.add(inputs.limits.*limit.value);
    }
    mix.add(std::bit_cast<std::uintptr_t>(inputs.surface));
    mix.add(std::uint64_t{inputs.scene_id});
    mix.add(inputs.global_alpha_rad2_per_m2);
    mix.add(std::uint64_t{inputs.requested_stop});
    mix.add(std::uint64_t{inputs.released_stop});
    mix.add(std::uint64_t{inputs.reset_count});
    mix.add(std::uint64_t{inputs.release});
    mix.add(std::uint64_t{inputs.heartbeat});
    mix.add(std::uint64_t{inputs.fixed_x0_m.has_value()});
    for (int axis = 0; axis < 3; ++axis) {
        mix.add(inputs.excitation_V[axis]);
        mix.add(inputs.fixed_x0_m.value_or(Vector3::Zero())[axis]);
    }
    return mix.sum();
}

struct SealedInputs {
    SealedInputs() : SealedInputs(ServoInputs{}) {}
    explicit SealedInputs(const ServoInputs &sealed)
        : inputs(sealed), checksum(servo::checksum(sealed)) {}

    [[nodiscard]] bool is_whole() const { return checksum == servo::checksum(inputs); }

    ServoInputs inputs;
    std::uint32_t checksum;
};

const contact::HapticSurface kSurface;

ServoInputs any_inputs(std::mt19937_64 &random) {
    std::uniform_real_distribution<double> share(0.0, 1.0);
    ServoInputs inputs;
    for (const control::Parameter &parameter : control::kParameters) {
        inputs.tuning.*parameter.value =
            parameter.minimum + share(random) * (parameter.maximum - parameter.minimum);
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
    inputs.requested_stop = static_cast<std::uint32_t>(random());
    inputs.released_stop = static_cast<std::uint32_t>(random());
    inputs.reset_count = static_cast<std::uint32_t>(random());
    inputs.heartbeat = static_cast<std::uint32_t>(random());
    inputs.excitation_V.setConstant(share(random));
    if (share(random) < 0.5) {
        inputs.fixed_x0_m = Vector3::Constant(share(random));
    }
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

/// Every bit of every field; one bit of a bool, none of padding.
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
        for (int axis = 0; axis < 3; ++axis) {
            bits.push_back({"excitation", [bit, axis](ServoInputs &inputs) {
                                inputs.excitation_V[axis] =
                                    flipped_double(inputs.excitation_V[axis], bit);
                            }});
        }
        bits.push_back({"global_alpha", [bit](ServoInputs &inputs) {
                            inputs.global_alpha_rad2_per_m2 =
                                flipped_double(inputs.global_alpha_rad2_per_m2, bit);
                        }});
    }
    for (int bit = 0; bit < 32; ++bit) {
        for (std::uint32_t ServoInputs::*field :
             {&ServoInputs::scene_id, &ServoInputs::requested_stop, &ServoInputs::released_stop,
              &ServoInputs::reset_count, &ServoInputs::heartbeat}) {
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
    bits.push_back({"release", [](ServoInputs &inputs) { inputs.release = !inputs.release; }});
    return bits;
}

TEST(SealedInputs, DetectAnyFlippedBit) {
    std::mt19937_64 random(9);
    const std::vector<Bit> bits = every_bit();
    EXPECT_EQ(bits.size(), 64U * (6 + 10 + 3 + 2) + 32U * 5 + 8U * 2 + 1);
    for (int run = 0; run < 50; ++run) {
        SealedInputs sealed(run == 0 ? ServoInputs{} : any_inputs(random));
        for (const Bit &bit : bits) {
            bit.flip(sealed.inputs);
            ASSERT_FALSE(sealed.is_whole()) << bit.name;
            bit.flip(sealed.inputs);
            ASSERT_TRUE(sealed.is_whole()) << bit.name;
        }
    }
}

TEST(ServoInputs, ArriveIntactAtAnyRate) {
    constexpr std::uint32_t kPublished = 20'000;
    constexpr std::size_t kSets = 64;
    std::mt19937_64 random(10);
    std::vector<ServoInputs> sets;
    sets.reserve(kSets);
    for (std::size_t i = 0; i < kSets; ++i) {
        sets.push_back(any_inputs(random));
    }
    LatestValue<SealedInputs> mailbox;
    std::thread window([&] {
        for (std::uint32_t i = 1; i <= kPublished; ++i) {
            ServoInputs inputs = sets[i % sets.size()];
            inputs.heartbeat = i;
            mailbox.publish(SealedInputs(inputs));
        }
    });
    std::uint32_t last = 0;
    while (last < kPublished) {
        const SealedInputs &arrived = mailbox.latest();
        EXPECT_TRUE(arrived.is_whole());
        EXPECT_GE(arrived.inputs.heartbeat, last);
        if (HasFailure()) {
            break;
        }
        last = arrived.inputs.heartbeat;
    }
    window.join();
}

} // namespace
} // namespace springdrive::servo
