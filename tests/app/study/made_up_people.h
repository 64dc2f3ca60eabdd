// Two people and two windows that are made up, for sittings without a screen: in lockstep, each
// frame a sixtieth of a second.
#pragma once

#include "app/study/participant/answers.h"
#include "app/study/sitting/sitting.h"
#include "engine/study/protocol/protocol_file.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace springdrive::app::study_screen {

inline constexpr double kMadeUpFrame_s = 1.0 / 60.0;

/// A protocol of some trials.
inline study::Protocol short_protocol(const std::string &name) {
    study::Protocol protocol =
        study::read_protocol_file(testing::assets() / "protocols" / (name + ".toml"));
    protocol.timing.rest_s = 0.2;
    protocol.timing.approach_s = std::min(protocol.timing.approach_s, 0.8);
    protocol.timing.presentation_s = 1.0; // until a force has the direction wanted
    protocol.timing.pause_s = 0.1;
    protocol.timing.between_trials_s = 0.1;
    protocol.timing.response_s = 1.0;
    protocol.practice = {{60.0}, 2, 0, 2};
    protocol.catch_trials = {};
    protocol.breaks = {3, 1.0, 1.5};
    study::ConstantStimuli method;
    method.levels = {20.0, 60.0};
    method.repetitions = 1;
    method.blocks = 1;
    protocol.method = method;
    protocol.expected.reset();
    protocol.questionnaire.clear();
    protocol.windings = {25.0, 24.0, 60.0}; // warm already
    return protocol;
}

/// What the participant does: of a planned trial, which key and how long after the question; below
/// 0: nothing.
struct Decision {
    std::size_t key = 0;
    double after_s = 0.3;
};
inline Decision decision_of(const study::PlannedTrial &planned) {
    const std::size_t key = study::below(study::child(study::RandomKey{planned.seed}, 77), 2);
    const bool answers = study::uniform(study::child(study::RandomKey{planned.seed}, 78)) > 0.15;
    return {key, answers ? 0.3 : -1.0};
}

/// Two people and two windows that are made up.
class MadeUpPort {
public:
    MadeUpPort(session::Session &session, const study::Protocol &protocol)
        : session_(session), protocol_(protocol) {}

    SittingFrame show(const ParticipantPicture &picture, const SittingState &state) {
        session_.advance(kMadeUpFrame_s);
        EXPECT_LT(++frames_, 60 * 600) << "stuck: " << description(state.step); // ten minutes
        if (frames_ >= 60 * 600) {
            orders.stops = true;
        }
        steps.insert(state.step);
        if (on_frame) {
            on_frame(picture, state);
        }
        SittingFrame frame;
        frame.orders = orders;
        frame.inputs = std::exchange(inputs, {});
        if (std::exchange(presses_emergency_stop, false)) {
            session_.servo().emergency_stop();
        }
        orders.repeats = orders.skips_to_break = orders.resets_device = false;
        const double now_s = session_.servo().now_s();
        switch (state.step) {
        case SittingStep::response: {
            const Decision decision = decision_of(*state.trial);
            asked_s_ = asked_s_ < 0.0 ? now_s : asked_s_;
            if (!is_silent && decision.after_s >= 0.0 && now_s - asked_s_ >= decision.after_s) {
                frame.inputs.push_back(key(protocol_.responses.keys[decision.key], now_s));
            }
            break;
        }
        case SittingStep::practice_ends: // no more of it
            frame.inputs.push_back(key(protocol_.responses.keys.at(1), now_s));
            break;
        case SittingStep::instructions:
        case SittingStep::noise_check:
        case SittingStep::practice_begins:
        case SittingStep::block_begins:
        case SittingStep::in_break:
        case SittingStep::over:
            frame.inputs.push_back(key(protocol_.responses.keys.front(), now_s));
            break;
        default:
            asked_s_ = -1.0;
            break;
        }
        return frame;
    }

    [[nodiscard]] ShowsScene scene_shower() {
        return [this](const scene::Scene &scene, const scene::TouchSpot &spot) {
            if (on_scene) {
                on_scene(scene, spot);
            }
        };
    }

    static ParticipantInput key(const std::string &name, double clock_s) {
        ParticipantInput input;
        input.name = input_name(name);
        input.clock_s = clock_s;
        return input;
    }

    ExperimenterOrders orders;
    std::vector<ParticipantInput> inputs; ///< of the next frame
    bool presses_emergency_stop = false;  ///< in the next frame
    bool is_silent = false;               ///< answers nothing any more
    std::function<void(const ParticipantPicture &, const SittingState &)> on_frame;
    std::function<void(const scene::Scene &, const scene::TouchSpot &)> on_scene;
    std::set<SittingStep> steps;

private:
    session::Session &session_;
    const study::Protocol &protocol_;
    double asked_s_ = -1.0;
    int frames_ = 0;
};

/// Shows all of a Sitting, or of what is resumed like one.
template <typename Resumed, typename ItsWindow>
void show_to_end(Resumed &resumed, ItsWindow &window) {
    resumed.start();
    while (!resumed.is_over()) {
        resumed.resume(window.show(resumed.picture(), resumed.state()));
    }
}

inline Resumable<> present_into(TrialPresenter &presenter, std::optional<study::Trial> &result) {
    result = co_await presenter.present();
}

/// Presents a trial by itself, on a device of its own, to a port that `prepare` has seen.
/// @param before     just before it, when the motors run
/// @param is_enough  whether nothing after that frame is wanted
inline void present_alone(const study::Protocol &protocol, const study::ProtocolFolders &folders,
                          const study::PlannedTrial &planned,
                          const std::function<void(MadeUpPort &)> &prepare,
                          const std::function<void(session::Session &)> &before = {},
                          const std::function<bool(const SittingState &)> &is_enough = {}) {
    session::SessionOptions options;
    options.scene = testing::assets() / "scenes" / "plate.gltf";
    options.device.file = study::device_file_of(protocol, folders);
    options.lockstep = true;
    session::Session session(options);
    MadeUpPort port(session, protocol);
    prepare(port);
    SittingState state;
    const study::StudySetting setting = study::study_setting(protocol, folders);
    std::optional<Frames> frames(std::in_place); // ends before the presenter does
    TrialPresenter presenter(
        {protocol, setting, folders, session, state, port.scene_shower(),
         [&](ParticipantPicture picture) { return frames->show(std::move(picture)); }});
    const auto show_all = [&](Resumable<> whole) {
        frames->start(std::move(whole));
        while (!frames->is_over() && !(is_enough && is_enough(state))) {
            frames->resume(port.show(frames->picture(), state));
        }
        return frames->is_over();
    };
    session.start();
    ASSERT_TRUE(show_all(presenter.set_up(planned)));
    presenter.lead_to_start();
    while (session.latest().safety.state != servo::SafetyState::running) {
        session.advance(kMadeUpFrame_s);
    }
    if (before) {
        before(session);
    }
    std::optional<study::Trial> result;
    if (show_all(present_into(presenter, result))) {
        EXPECT_TRUE(result && result->marks.empty() && result->safety_events.empty())
            << (result && !result->marks.empty() ? result->marks.front() : "");
    }
    frames.reset();
}

/// A trial of each condition that is compared, at each of these levels and with these targets.
inline std::vector<study::PlannedTrial> trials_of_conditions(const study::Protocol &protocol,
                                                             const std::vector<double> &levels,
                                                             const std::vector<int> &targets) {
    std::vector<study::PlannedTrial> trials;
    for (std::size_t condition = 0; condition < protocol.conditions.size(); ++condition) {
        if (!study::is_used(protocol, condition) ||
            study::standard_condition_of(protocol) == condition) {
            continue;
        }
        for (const double level : levels) {
            for (const int target : targets) {
                study::PlannedTrial planned;
                planned.condition = protocol.conditions[condition].name;
                planned.level = level;
                planned.target = target + 1;
                trials.push_back(planned);
            }
        }
    }
    return trials;
}

} // namespace springdrive::app::study_screen
