// The whole sequence of a participant's trials: blocks in the order that counterbalancing gives
// them, trials as each block asks for them.
//
// What comes next is a function of the protocol, the participant's number and the trials in the
// store. A session that was killed, or stopped, is therefore resumed with the sequence of an
// undisturbed one.
#pragma once

#include "engine/study/methods/block.h"
#include "engine/study/protocol/protocol.h"
#include "engine/study/store/study_contents.h"

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace springdrive::study {

/// A block that was begun and ended.
struct EndedBlock {
    std::size_t block = 0; ///< index into `Protocol::blocks`
    BlockState state = BlockState::complete;

    friend bool operator==(const EndedBlock &, const EndedBlock &) = default;
};

class Sequence {
public:
    /// @param participant  the number, from 1
    /// @pre validate(protocol) is empty
    Sequence(const Protocol &protocol, int participant);

    /// The same however often it is asked; nothing after the last trial of the last block.
    [[nodiscard]] std::optional<PlannedTrial> next() const;

    /// The trial that came next, as it is stored.
    /// @throw InputError if it is not `next()`: the study was run with another protocol.
    void add(const Trial &trial);

    /// Blocks in this participant's order, as indices into `Protocol::blocks`.
    [[nodiscard]] std::span<const int> order() const { return order_; }
    /// In that order. A block with too many marked trials has ended unfinished.
    [[nodiscard]] std::span<const EndedBlock> ended() const { return ended_; }

private:
    void begin_block();
    [[nodiscard]] PlannedTrial planned_of(const BlockTrial &presented) const;

    Protocol protocol_;
    RandomKey key_; ///< of the participant
    std::vector<int> order_;
    std::vector<EndedBlock> ended_;
    std::optional<BlockRun> run_;      ///< of the present block; nothing after the last
    int position_ = 1;                 ///< in the present block
    std::vector<PlannedTrial> marked_; ///< of the present block, and not presented again yet
};

/// The name of what a level is: the parameter under test with its unit, such as "turn_deg"; with
/// "_added" or "_taken_off" where levels are differences from the standard.
[[nodiscard]] std::string level_name_of(const Protocol &protocol);

/// Whether the response is the right one; nothing without a response, and where the task has no
/// right one: yes/no and adjustment.
[[nodiscard]] std::optional<bool> is_correct(const Task &task, const Trial &trial);

/// What the method learns of a stored trial.
[[nodiscard]] Outcome outcome_of(const Protocol &protocol, const Trial &trial);

/// The sequence after these trials of the participant, in their order.
/// @throw InputError as `Sequence::add` does.
[[nodiscard]] Sequence sequence_after(const Protocol &protocol, int participant,
                                      std::span<const Trial> trials);

} // namespace springdrive::study
