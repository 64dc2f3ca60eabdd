#include "engine/study/methods/constant_stimuli.h"

#include "engine/study/methods/wrong_value.h"

#include <cstddef>
#include <span>

namespace springdrive::study {

std::string validate(const ConstantStimuli &method) {
    return first_of(
        {unless_rising("levels", method.levels, 1), out_of_range(kConstantStimuliFields, method)});
}

int max_trials(const ConstantStimuli &method) {
    return static_cast<int>(method.levels.size()) * method.repetitions * method.blocks;
}

ConstantStimuliRun::ConstantStimuliRun(const ConstantStimuli &method, RandomKey key)
    : method_(method), key_(key) {
    start_block();
}

std::optional<MethodTrial> ConstantStimuliRun::next() const {
    return is_done() ? std::nullopt : std::optional(MethodTrial{left_.front(), 0});
}

void ConstantStimuliRun::add(const PastMethodTrial &trial) {
    left_.erase(left_.begin());
    if (trial.outcome.marked) {
        // Not the first place, so that a participant who felt half of it is not asked at once.
        const std::size_t others = left_.size();
        const std::size_t place =
            others == 0 ? 0 : 1 + below(child(child(key_, 1), trials_), others);
        left_.insert(left_.begin() + static_cast<std::ptrdiff_t>(place), trial.presented.level);
    }
    ++trials_;
    if (left_.empty() && blocks_started_ < method_.blocks) {
        start_block();
    }
}

void ConstantStimuliRun::start_block() {
    for (int i = 0; i < method_.repetitions; ++i) {
        left_.insert(left_.end(), method_.levels.begin(), method_.levels.end());
    }
    shuffle(child(child(key_, 0), static_cast<std::uint64_t>(blocks_started_)), std::span(left_));
    ++blocks_started_;
}

} // namespace springdrive::study
