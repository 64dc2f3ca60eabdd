// A session of a study: trial after trial is presented, answered and stored, until the participant
// is through or something ends it. Who presents and who answers is the caller's: a person at the
// screens takes a RunningSession from trial to trial, a simulated hand and observer are conducted.
#pragma once

#include "engine/study/conduct/sequence.h"
#include "engine/study/store/study_store.h"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace springdrive::study {

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
    /// with marks besides those of marking.h, and if it is to be presented again whatever the
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

} // namespace springdrive::study
