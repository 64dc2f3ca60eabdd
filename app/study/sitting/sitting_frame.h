// What both people did in a frame.
#pragma once

#include "app/study/participant/participant_input.h"

#include <vector>

namespace springdrive::app::study_screen {

/// What the experimenter wants.
struct ExperimenterOrders {
    bool is_paused = false; ///< between trials, for as long as it is set
    bool stops = false;     ///< ends the session now; it can be resumed
    bool participant_leaves = false;
    bool repeats = false;        ///< the present trial does not count, and comes again
    bool skips_to_break = false; ///< a break before the next trial
    bool resets_device = false;  ///< after a stop
};

struct SittingFrame {
    std::vector<ParticipantInput> inputs; ///< in order; times by `ServoRun::now_s`
    ExperimenterOrders orders;
};

} // namespace springdrive::app::study_screen
