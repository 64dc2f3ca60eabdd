// A study as it is run: what a trial presents and whether that was what it was to be, the sequence
// of trials, a session, and where each participant stands.
#pragma once

#include "engine/study/methods/block.h"
#include "engine/study/protocol/protocol.h"
#include "engine/study/protocol/study_setting.h"
#include "engine/study/stimuli/stimulus.h"
#include "engine/study/store/study_contents.h"
#include "engine/study/store/study_store.h"

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::study {

/// Why a trial does not count, a line for each value out of its band: outside, or intended and not
/// measured. Empty: it counts. The bands are those of `kStimulusMeasures`, and of "lateness_s"
/// `Marking::lateness_s`; values with other names have none.
[[nodiscard]] std::vector<std::string> marks_of(const Marking &marking,
                                                std::span<const Presentation> presentations);

/// Whether a trial with these marks is presented again. Without an answer a method has nothing to
/// learn from, whatever the protocol says of repeating.
[[nodiscard]] bool comes_again(const Marking &marking, const std::vector<std::string> &marks,
                               const Response &response);

/// Index into `Protocol::conditions`. @pre the trial is of a sequence of the protocol
[[nodiscard]] std::size_t condition_of(const Protocol &protocol, const PlannedTrial &planned);

/// One after the other. @pre validate(protocol) is empty; the trial is of its sequence
[[nodiscard]] std::vector<Presented> intervals_of(const Protocol &protocol,
                                                  const PlannedTrial &planned);

/// The comparison alone, at another level than the planned one: of an adjustment.
[[nodiscard]] Presented comparison_at(const Protocol &protocol, const PlannedTrial &planned,
                                      double level);

/// Every measure that was intended or delivered, and lateness_s, all with the intended value;
/// peak_force_N and aside_m without. How far which may be off is for `marks_of`.
[[nodiscard]] Presentation presentation_of(const StimulusMeasures &intended,
                                           const DeliveredStimulus &delivered);

/// The tuning in contact, servo rate and delay, by their names in protocol files.
[[nodiscard]] std::vector<Setting> settings_of(const Condition &condition);

// The whole sequence of a participant's trials: blocks in the order that counterbalancing gives
// them, trials as each block asks for them.
//
// What comes next is a function of the protocol, the participant's number and the trials in the
// store. A session that was killed, or stopped, is therefore resumed with the sequence of an
// undisturbed one.

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
/// For display, with the unit: "turn_deg [°]"
[[nodiscard]] std::string level_label(const Protocol &protocol);

/// Whether the response is the right one; nothing without a response, and where the task has no
/// right one: yes/no and adjustment.
[[nodiscard]] std::optional<bool> is_correct(const Task &task, const Trial &trial);

/// What the method learns of a stored trial.
[[nodiscard]] Outcome outcome_of(const Protocol &protocol, const Trial &trial);

/// The sequence after these trials of the participant, in their order.
/// @throw InputError as `Sequence::add` does.
[[nodiscard]] Sequence sequence_after(const Protocol &protocol, int participant,
                                      std::span<const Trial> trials);

// A session of a study: trial after trial is presented, answered and stored, until the participant
// is through or something ends it. Who presents and who answers is the caller's: a person at the
// screens takes a RunningSession from trial to trial, a simulated hand and observer are conducted.

/// A participant's session, as a whole or from where it was left, trial by trial.
class RunningSession {
public:
    /// @param session  of the store, begun and not ended. All must outlive this
    RunningSession(StudyStore &store, const Protocol &protocol, const Session &session);

    /// The trial that comes next; nothing when the participant is through.
    [[nodiscard]] std::optional<PlannedTrial> next() const { return sequence_.next(); }

    /// Completes the trial and stores it: it is on the disk afterwards.
    /// @return how the session ends: more trips than the protocol bears, or the time over
    /// @throw InputError from the store, or as `Sequence::add` does
    std::optional<SessionEnding> add(Trial trial, UtcTime at = utc_now());

private:
    StudyStore &store_;
    const Protocol &protocol_;
    const Session &session_;
    Sequence sequence_;
    int trips_ = 0;
};

/// Ends a session after an error, as failed, if the store can still do that.
void end_as_failed(StudyStore &store, SessionId session, UtcTime at = utc_now());

struct Conduct {
    /// Presents a trial and takes the answer: the planned trial, filled to its response and time;
    /// with marks besides those of `marks_of`, and if it is to be presented again whatever the
    /// protocol says of repeating, so told by a mark, with `is_presented_again`. Nothing if the
    /// device was lost, or the session was stopped, in the midst of it: then the trial did not take
    /// place, and comes again.
    std::function<std::optional<Trial>(const PlannedTrial &)> present;
    /// Before each trial: nothing to go on, or how the session ends. Also asked after `present`
    /// gave nothing; without an answer the device is lost.
    std::function<std::optional<SessionEnding>()> ends;
    std::function<UtcTime()> now = utc_now;
};

/// Runs the participant's session, as a whole or from where it was left, until the end that it
/// returns and stores: complete, what `ends` says, a device lost, more trips than the protocol
/// bears, or the time over. Each trial is on the disk before the next begins.
/// @param session  of the store, begun and not ended
/// @throw InputError from the store, or as `Sequence::add` does; the session is then ended as
///        failed, if the store can still do that.
SessionEnding conduct(StudyStore &store, const Protocol &protocol, const Session &session,
                      const Conduct &how);

struct Progress {
    std::string participant;
    int number = 1;
    int sessions = 0;
    std::optional<SessionEnding> last_ending; ///< nothing without a session, and while one runs
    std::vector<DeviceKind> devices;          ///< of the sessions, each once
    int trials = 0;                           ///< all of them
    int practice = 0;
    int marked = 0;
    int blocks_unfinished = 0;        ///< ended because too many of their trials were marked
    std::optional<PlannedTrial> next; ///< nothing after the last trial
    std::size_t next_block = 0;       ///< of that, index into `Protocol::blocks`
    bool has_open_questions = false;  ///< the session was ended in those after the last trial
};

/// Of all participants, in the order in which they were added.
/// @pre validate(protocol) is empty
/// @throw InputError as `sequence_after` does
[[nodiscard]] std::vector<Progress> progress_of(const Protocol &protocol,
                                                const StudyContents &contents);

/// The questions that the participant has not answered, those who would rather not say included.
[[nodiscard]] std::vector<QuestionnaireItem> open_questions(const Protocol &protocol,
                                                            const StudyContents &contents,
                                                            std::string_view participant,
                                                            QuestionnaireTime when);

} // namespace springdrive::study
