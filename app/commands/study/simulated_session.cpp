#include "app/commands/study/simulated_session.h"

#include "app/host/ending_signal.h"
#include "base/machine_name.h"

namespace springdrive::app {

namespace {

study::Session begun_session(study::StudyStore &store, const SessionPlan &plan) {
    study::Session session;
    session.participant = plan.participant;
    session.started = study::utc_now();
    session.device = study::DeviceKind::simulated;
    session.device_name = plan.setting.device.name;
    session.software = SPRINGDRIVE_VERSION;
    session.host = machine_name();
    session.facts = facts_of(plan.observer);
    session.id = store.begin(session);
    return session;
}

std::optional<study::SessionEnding> if_asked_to_end() {
    return asked_to_end() ? std::optional(study::SessionEnding::stopped) : std::nullopt;
}

} // namespace

void run_simulated_session(study::StudyStore &store, const SessionPlan &plan) {
    study::SimulatedParticipant participant;
    participant.function = plan.observer.function;
    participant.seed = plan.observer.seed;
    study::SimulatedSitting sitting(plan.protocol, plan.setting, participant, plan.observer.felt);
    study::Conduct how;
    how.present = [&sitting](const study::PlannedTrial &planned) {
        return sitting.present(planned);
    };
    how.ends = [&plan] {
        plan.before_trial();
        return if_asked_to_end();
    };
    study::conduct(store, plan.protocol, begun_session(store, plan), how);
}

} // namespace springdrive::app
