#include "engine/study/conduct/sequence.h"

#include "base/input_error.h"

#include <fmt/core.h>

#include <algorithm>
#include <string>
#include <variant>

namespace springdrive::study {

namespace {

constexpr int kNobody = 0; ///< whose key draws what is the same for all participants

/// What is drawn from the key of a block.
enum class DrawnInBlock : std::uint64_t { sequence, trials };

RandomKey block_key(RandomKey participant, std::size_t place, DrawnInBlock what) {
    return child(child(participant, place), static_cast<std::uint64_t>(what));
}

bool presents_the_same(const PlannedTrial &one, const PlannedTrial &other) {
    return one.is_practice == other.is_practice && one.is_catch == other.is_catch &&
           one.condition == other.condition && one.track == other.track && one.level == other.level;
}

/// Names of tracks, from 1; empty where there is one only.
std::string track_name(const Method &method, int track) {
    const auto *staircases = std::get_if<Staircases>(&method);
    const bool has_several = staircases != nullptr && staircases->start_levels.size() > 1;
    return has_several ? std::to_string(track + 1) : std::string();
}

} // namespace

Sequence::Sequence(const Protocol &protocol, int participant)
    : protocol_(protocol), key_(key_of(static_cast<std::uint64_t>(protocol.seed), participant)),
      order_(order_of(protocol.counterbalancing, static_cast<int>(protocol.blocks.size()),
                      participant, key_of(static_cast<std::uint64_t>(protocol.seed), kNobody))) {
    begin_block();
}

void Sequence::begin_block() {
    const std::size_t place = ended_.size();
    position_ = 1;
    marked_.clear();
    run_.reset();
    if (place < order_.size()) {
        run_.emplace(block_of(protocol_, static_cast<std::size_t>(order_[place]), place == 0),
                     block_key(key_, place, DrawnInBlock::sequence));
    }
}

std::optional<PlannedTrial> Sequence::next() const {
    const std::optional<BlockTrial> presented = run_ ? run_->next() : std::nullopt;
    return presented ? std::optional(planned_of(*presented)) : std::nullopt;
}

PlannedTrial Sequence::planned_of(const BlockTrial &presented) const {
    const std::size_t place = ended_.size();
    PlannedTrial trial;
    trial.place = {static_cast<int>(place) + 1, position_, 1};
    const ProtocolBlock &block = protocol_.blocks[static_cast<std::size_t>(order_[place])];
    const auto series = static_cast<std::size_t>(presented.series);
    trial.condition = protocol_.conditions[block.conditions[series]].name;
    trial.track = track_name(protocol_.method, presented.track);
    trial.is_practice = presented.kind == TrialKind::practice;
    trial.is_catch = presented.kind == TrialKind::catch_trial;
    trial.seed =
        child(block_key(key_, place, DrawnInBlock::trials), static_cast<std::uint64_t>(position_))
            .bits;
    trial.level_name = level_name_of(protocol_);
    trial.level = presented.level;
    if (is_forced_choice(protocol_.task.kind)) {
        trial.target = presented.target + 1;
    }
    const auto again = std::ranges::find_if(
        marked_, [&trial](const PlannedTrial &before) { return presents_the_same(before, trial); });
    if (again != marked_.end()) {
        trial.repetition_of = again->place;
    }
    return trial;
}

void Sequence::add(const Trial &trial) {
    const std::optional<BlockTrial> presented = run_ ? run_->next() : std::nullopt;
    const std::optional<PlannedTrial> planned =
        presented ? std::optional(planned_of(*presented)) : std::nullopt;
    if (!planned || *planned != trial) {
        throw InputError(fmt::format(
            "{} of participant {} is not what the study's protocol presents there: it was run with "
            "another protocol or version; keep this study as it is, and go on in a new one",
            text_of(trial.place), trial.participant));
    }
    if (planned->repetition_of) {
        std::erase_if(marked_, [&planned](const PlannedTrial &before) {
            return before.place == *planned->repetition_of;
        });
    }
    const Outcome outcome = outcome_of(protocol_, trial);
    if (outcome.marked) {
        marked_.push_back(*planned);
    }
    run_->add({*presented, outcome});
    ++position_;
    if (const BlockState state = run_->state(); state != BlockState::running) {
        ended_.push_back({static_cast<std::size_t>(order_[ended_.size()]), state});
        begin_block();
    }
}

std::string level_name_of(const Protocol &protocol) {
    switch (protocol.variable.level) {
    case LevelMeaning::added:
        return protocol.variable.parameter + "_added";
    case LevelMeaning::taken_off:
        return protocol.variable.parameter + "_taken_off";
    case LevelMeaning::value:
        break;
    }
    return protocol.variable.parameter;
}

std::optional<bool> is_correct(const Task &task, const Trial &trial) {
    const auto *chosen = std::get_if<Chosen>(&trial.response);
    if (!is_forced_choice(task.kind) || chosen == nullptr || !trial.target) {
        return std::nullopt;
    }
    return chosen->alternative == *trial.target;
}

Outcome outcome_of(const Protocol &protocol, const Trial &trial) {
    Outcome outcome;
    outcome.marked = trial.is_presented_again;
    if (const auto *answer = std::get_if<YesNo>(&trial.response)) {
        outcome.positive = answer->yes;
    } else if (const auto *adjusted = std::get_if<Adjusted>(&trial.response)) {
        outcome.setting = adjusted->level;
    } else {
        outcome.positive = is_correct(protocol.task, trial).value_or(false);
    }
    return outcome;
}

Sequence sequence_after(const Protocol &protocol, int participant, std::span<const Trial> trials) {
    Sequence sequence(protocol, participant);
    for (const Trial &trial : trials) {
        sequence.add(trial);
    }
    return sequence;
}

} // namespace springdrive::study
