// A session of a study: trial after trial is presented, answered and stored, until the participant
// is through or something ends it. Who presents and who answers is the caller's: a simulated hand
// and observer, or a person at the screens.
#pragma once

#include "engine/study/conduct/sequence.h"
#include "engine/study/store/study_store.h"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace springdrive::study {

/// What came of presenting a trial.
struct TrialResult {
    std::vector<Presentation> presentations;
    Response response;
    std::optional<double> response_time_s;
    std::vector<Setting> tuning; ///< in force in contact
    std::vector<std::optional<double>> windings_degC;
    std::vector<SafetyEvent> safety_events; ///< one at least if the safety monitor tripped
    std::uint64_t missed_deadlines = 0;
    std::optional<RecordLink> record;
    std::vector<std::string> marks; ///< why it does not count, besides those of marking.h
    bool is_wanted_again = false;   ///< and marked; whatever the protocol says of repeating
};

struct Conduct {
    /// Presents a trial and takes the answer. Nothing if the device was lost, or the session was
    /// stopped, in the midst of it: then the trial did not take place, and comes again.
    std::function<std::optional<TrialResult>(const PlannedTrial &)> present;
    /// Before each trial: nothing to go on, or how the session ends. Also asked after `present`
    /// gave nothing; without an answer the device is lost.
    std::function<std::optional<SessionEnding>()> ends;
    /// After the last trial, before the session is complete, such as questions: nothing, or how the
    /// session ends instead. It comes again in the next session then, which has no trials.
    std::function<std::optional<SessionEnding>()> after_last = [] { return std::nullopt; };
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
