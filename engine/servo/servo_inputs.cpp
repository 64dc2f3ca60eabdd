#include "engine/servo/servo_inputs.h"

#include "engine/control/parameters.h"

#include <bit>

namespace springdrive::servo {

namespace {

/// FNV-1a over words: quick, and every field counts.
class Mix {
public:
    void add(std::uint64_t word) noexcept {
        for (; word != 0; word >>= 32U) {
            hash_ = (hash_ ^ (word & 0xffffffffU)) * 0x100000001b3U;
        }
        hash_ = (hash_ ^ 0x9eU) * 0x100000001b3U; // so that a zero counts, and where a word ends
    }
    void add(double value) noexcept { add(std::bit_cast<std::uint64_t>(value)); }
    [[nodiscard]] std::uint32_t sum() const noexcept {
        return static_cast<std::uint32_t>(hash_ ^ (hash_ >> 32U));
    }

private:
    std::uint64_t hash_ = 0xcbf29ce484222325U;
};

std::uint32_t checksum(const ServoInputs &inputs) noexcept {
    Mix mix;
    for (const control::Parameter &parameter : control::kParameters) {
        mix.add(inputs.tuning.*parameter.value);
    }
    mix.add(static_cast<std::uint64_t>(inputs.tuning.map));
    mix.add(static_cast<std::uint64_t>(inputs.tuning.alpha_mode));
    for (const SafetyLimit &limit : kSafetyLimits) {
        mix.add(inputs.limits.*limit.value);
    }
    mix.add(reinterpret_cast<std::uintptr_t>(inputs.surface)); // NOLINT: its identity, no access
    mix.add(std::uint64_t{inputs.scene_id});
    mix.add(inputs.global_alpha_rad2_per_m2);
    mix.add(std::uint64_t{inputs.emergency_stop});
    mix.add(std::uint64_t{inputs.stop_count});
    mix.add(std::uint64_t{inputs.reset_count});
    mix.add(std::uint64_t{inputs.release});
    mix.add(std::uint64_t{inputs.heartbeat});
    return mix.sum();
}

} // namespace

ServoInputs sealed(ServoInputs inputs) noexcept {
    inputs.checksum = checksum(inputs);
    return inputs;
}

bool is_whole(const ServoInputs &inputs) noexcept { return inputs.checksum == checksum(inputs); }

} // namespace springdrive::servo
