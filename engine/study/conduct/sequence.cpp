#include "engine/study/conduct/sequence.h"

#include "base/input_error.h"
#include "engine/study/conduct/stored_trial.h"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

namespace springdrive::study {

namespace {

constexpr int kNobody = 0; ///< whose key draws what is the same for all participants

/// What is drawn from the key of a block.
enum class DrawnInBlock : std::uint64_t { sequence, trials };

RandomKey block_key(RandomKey participant, std::size_t place, DrawnInBlock what) {
    return child(child(participant, place), static_cast<std::uint64_t>(what));
}

bool presents_the_same(const PlannedTrial &one, const PlannedTrial &other) {
    return one.presented.kind == other.presented.kind &&
           one.presented.series == other.presented.series &&
           one.presented.track == other.presented.track &&
           one.presented.level == other.presented.level;
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
    if (!presented) {
        return std::nullopt;
    }
    const std::size_t place = ended_.size();
    PlannedTrial trial;
    trial.place = {static_cast<int>(place) + 1, position_, 1};
    trial.block = static_cast<std::size_t>(order_[place]);
    trial.condition =
        protocol_.blocks[trial.block].conditions[static_cast<std::size_t>(presented->series)];
    trial.presented = *presented;
    trial.key =
        child(block_key(key_, place, DrawnInBlock::trials), static_cast<std::uint64_t>(position_));
    const auto again = std::ranges::find_if(
        marked_, [&trial](const PlannedTrial &before) { return presents_the_same(before, trial); });
    if (again != marked_.end()) {
        trial.repetition_of = again->place;
    }
    return trial;
}

void Sequence::add(const Trial &trial) {
    const std::optional<PlannedTrial> planned = next();
    if (!planned || !is_of(protocol_, *planned, trial)) {
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
    run_->add({planned->presented, outcome});
    ++position_;
    if (const BlockState state = run_->state(); state != BlockState::running) {
        ended_.push_back({planned->block, state});
        begin_block();
    }
}

Sequence sequence_after(const Protocol &protocol, int participant, std::span<const Trial> trials) {
    Sequence sequence(protocol, participant);
    for (const Trial &trial : trials) {
        sequence.add(trial);
    }
    return sequence;
}

} // namespace springdrive::study
