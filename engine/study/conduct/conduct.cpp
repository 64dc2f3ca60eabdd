#include "engine/study/conduct/conduct.h"

#include "base/input_error.h"
#include "engine/study/conduct/marking.h"
#include "engine/study/conduct/sequence.h"

#include <fmt/core.h>

#include <chrono>
#include <utility>
#include <variant>

namespace springdrive::study {

namespace {

/// What is stored with it besides what came of it, and why it does not count.
void complete(Trial &trial, const Protocol &protocol, const Session &session, UtcTime at) {
    const bool was_broken_off = !trial.marks.empty() || !trial.safety_events.empty();
    trial.participant = session.participant;
    trial.session = session.id;
    trial.software = session.software;
    trial.at = at;
    trial.is_correct = is_correct(protocol.task, trial);
    for (std::string &mark : marks_of(protocol.marking, trial.presentations)) {
        trial.marks.push_back(std::move(mark));
    }
    for (const SafetyEvent &event : trial.safety_events) {
        trial.marks.push_back("the safety monitor tripped: " + event.text);
    }
    if (std::holds_alternative<NoResponse>(trial.response) && !was_broken_off) {
        trial.marks.push_back(
            fmt::format("no response in {:g} s", protocol.task.kind == TaskKind::adjustment
                                                     ? protocol.timing.presentation_s
                                                     : protocol.timing.response_s));
    }
    trial.is_presented_again =
        trial.is_presented_again || comes_again(protocol.marking, trial.marks, trial.response);
}

SessionEnding run_trials(StudyStore &store, const Protocol &protocol, const Session &session,
                         const Conduct &how) {
    RunningSession running(store, protocol, session);
    while (const std::optional<PlannedTrial> planned = running.next()) {
        if (const std::optional<SessionEnding> ending = how.ends()) {
            return *ending;
        }
        std::optional<Trial> trial = how.present(*planned);
        if (!trial) {
            return how.ends().value_or(SessionEnding::device_lost);
        }
        if (const auto ending = running.add(*std::move(trial), how.now())) {
            return *ending;
        }
    }
    return SessionEnding::completed;
}

} // namespace

RunningSession::RunningSession(StudyStore &store, const Protocol &protocol, const Session &session)
    : store_(store), protocol_(protocol), session_(session),
      sequence_(sequence_after(protocol,
                               participant_of(store.contents(), session.participant).number,
                               trials_of(store.contents(), session.participant))) {}

std::optional<SessionEnding> RunningSession::add(Trial trial, UtcTime at) {
    const std::chrono::duration<double, std::ratio<60>> longest(
        protocol_.stopping.longest_session_min);
    trips_ += trial.safety_events.empty() ? 0 : 1;
    complete(trial, protocol_, session_, at);
    store_.append(trial);
    sequence_.add(trial);
    if (trips_ > protocol_.stopping.max_trips && sequence_.next()) {
        return SessionEnding::safety_trip;
    }
    if (at - session_.started > longest && sequence_.next()) {
        return SessionEnding::stopped;
    }
    return std::nullopt;
}

void end_as_failed(StudyStore &store, SessionId session, UtcTime at) {
    try {
        store.end(session, SessionEnding::failed, at);
    } catch (const InputError &) { // the store says at the next opening that it was interrupted
    }
}

SessionEnding conduct(StudyStore &store, const Protocol &protocol, const Session &session,
                      const Conduct &how) {
    try {
        const SessionEnding ending = run_trials(store, protocol, session, how);
        store.end(session.id, ending, how.now());
        return ending;
    } catch (const InputError &) {
        end_as_failed(store, session.id, how.now());
        throw;
    }
}

} // namespace springdrive::study
