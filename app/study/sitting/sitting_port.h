// What a sitting needs of its two windows: it shows a picture, and is told what both people did.
#pragma once

#include "app/study/participant/participant_input.h"
#include "app/study/participant/participant_picture.h"
#include "app/study/sitting/sitting_state.h"
#include "engine/scene/scene.h"

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

class SittingPort {
public:
    SittingPort() = default;
    virtual ~SittingPort() = default;
    SittingPort(const SittingPort &) = delete;
    SittingPort &operator=(const SittingPort &) = delete;

    /// Shows this for a frame, and advances the session by it.
    virtual SittingFrame show(const ParticipantPicture &picture, const SittingState &state) = 0;

    /// The scene of the pictures that show one, and the spot marked in it, from now on.
    virtual void show_scene(const scene::Scene &scene, const scene::TouchSpot &spot) = 0;
};

} // namespace springdrive::app::study_screen
