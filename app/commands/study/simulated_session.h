// A session of a simulated participant, without a window.
#pragma once

#include "app/commands/study/observer_options.h"
#include "engine/study/conduct/conduct.h"
#include "engine/study/protocol/study_setting.h"

#include <functional>
#include <string>

namespace springdrive::app {

struct SessionPlan {
    const study::Protocol &protocol;
    const study::StudySetting &setting;
    std::string participant; ///< in the store
    SimulatedObserver observer;
    std::function<void()> before_trial; ///< for the progress
};

/// Runs it until the participant is through, the program is asked to end (after the present trial),
/// or something else ends it. It is stored as one on a simulated device.
/// @throw InputError as `study::conduct` does
void run_simulated_session(study::StudyStore &store, const SessionPlan &plan);

} // namespace springdrive::app
