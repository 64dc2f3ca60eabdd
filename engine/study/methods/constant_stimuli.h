// The method of constant stimuli: every level as often as every other, in an order by chance.
#pragma once

#include "engine/study/methods/random_key.h"
#include "engine/study/methods/scale.h"
#include "engine/study/methods/trial.h"

#include <cstdint>
#include <optional>
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

inline constexpr auto kConstantStimuliFields = std::to_array<Field<ConstantStimuli>>({
    {"levels", &ConstantStimuli::levels, "that are presented, rising", kTypedLevel, "", kRequired},
    {"repetitions", &ConstantStimuli::repetitions, "of each level in one round", 1.0, 1000.0},
    {"blocks", &ConstantStimuli::blocks, "rounds through all levels, each in an order by chance",
     1.0, 1000.0},
});

/// Empty if the method can be used; else the first bad key, with value and range.
[[nodiscard]] std::string validate(const ConstantStimuli &method);

[[nodiscard]] int max_trials(const ConstantStimuli &method);

/// The method while it runs; see MethodRun.
class ConstantStimuliRun {
public:
    ConstantStimuliRun(const ConstantStimuli &method, RandomKey key);

    [[nodiscard]] bool is_done() const { return left_.empty(); }
    [[nodiscard]] std::optional<MethodTrial> next() const;
    void add(const PastMethodTrial &trial);

private:
    void start_block();

    ConstantStimuli method_;
    RandomKey key_;
    std::vector<double> left_; ///< in the present block, the next one first
    int blocks_started_ = 0;
    std::uint64_t trials_ = 0; ///< marked ones too
};

} // namespace springdrive::study
