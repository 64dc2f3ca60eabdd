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
    const StudyContents contents = store.contents();
    Sequence sequence =
        sequence_after(protocol, participant_of(contents, session.participant).number,
                       trials_of(contents, session.participant));
    const std::chrono::duration<double, std::ratio<60>> longest(
        protocol.stopping.longest_session_min);
    int trips = 0;
    while (const std::optional<PlannedTrial> planned = sequence.next()) {
        if (const std::optional<SessionEnding> ending = how.ends()) {
            return *ending;
        }
        std::optional<Trial> trial = how.present(*planned);
        if (!trial) {
            return how.ends().value_or(SessionEnding::device_lost);
        }
        trips += trial->safety_events.empty() ? 0 : 1;
        const UtcTime at = how.now();
        complete(*trial, protocol, session, at);
        store.append(*trial);
        sequence.add(*trial);
        if (trips > protocol.stopping.most_trips && sequence.next()) {
            return SessionEnding::safety_trip;
        }
        if (at - session.started > longest && sequence.next()) {
            return SessionEnding::stopped;
        }
    }
    return how.after_last().value_or(SessionEnding::completed);
}

} // namespace

SessionEnding conduct(StudyStore &store, const Protocol &protocol, const Session &session,
                      const Conduct &how) {
    try {
        const SessionEnding ending = run_trials(store, protocol, session, how);
        store.end(session.id, ending, how.now());
        return ending;
    } catch (const InputError &) {
        try {
            store.end(session.id, SessionEnding::failed, how.now());
        } catch (const InputError &) { // the store says at the next opening that it was interrupted
        }
        throw;
    }
}

} // namespace springdrive::study
