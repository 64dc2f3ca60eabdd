// Two people and two windows that are made up, for sessions without a screen: in lockstep, each
// frame a sixtieth of a second. And whole sessions of them on the simulated device; the study is in
// a folder of its own.
#pragma once

#include "app/study/participant/answers.h"
#include "app/study/session/study_session.h"
#include "device/core/faults.h"
#include "engine/study/protocol/protocol.h"
#include "tests/app/study/headless_study.h"
#include "tests/support/devices.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
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

    StudySessionFrame show(const ParticipantPicture &picture, const StudySessionState &state) {
        session_.advance(kMadeUpFrame_s);
        EXPECT_LT(++frames_, 60 * 600) << "stuck: " << description(state.step); // ten minutes
        if (frames_ >= 60 * 600) {
            orders.stops = true;
        }
        steps.insert(state.step);
        if (on_frame) {
            on_frame(picture, state);
        }
        StudySessionFrame frame;
        frame.orders = orders;
        frame.inputs = std::exchange(inputs, {});
        if (std::exchange(presses_emergency_stop, false)) {
            session_.servo().emergency_stop();
        }
        orders.repeats = orders.skips_to_break = orders.resets_device = false;
        const double now_s = session_.servo().now_s();
        switch (state.step) {
        case StudySessionStep::response: {
            const Decision decision = decision_of(*state.trial);
            requested_s_ = requested_s_ < 0.0 ? now_s : requested_s_;
            if (!is_silent && decision.after_s >= 0.0 && now_s - requested_s_ >= decision.after_s) {
                frame.inputs.push_back(key(protocol_.responses.keys[decision.key], now_s));
            }
            break;
        }
        case StudySessionStep::practice_ends: // no more of it
            frame.inputs.push_back(key(protocol_.responses.keys.at(1), now_s));
            break;
        case StudySessionStep::instructions:
        case StudySessionStep::noise_check:
        case StudySessionStep::practice_begins:
        case StudySessionStep::block_begins:
        case StudySessionStep::in_break:
        case StudySessionStep::over:
            frame.inputs.push_back(key(protocol_.responses.keys.front(), now_s));
            break;
        default:
            requested_s_ = -1.0;
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
    std::function<void(const ParticipantPicture &, const StudySessionState &)> on_frame;
    std::function<void(const scene::Scene &, const scene::TouchSpot &)> on_scene;
    std::set<StudySessionStep> steps;

private:
    session::Session &session_;
    const study::Protocol &protocol_;
    double requested_s_ = -1.0;
    int frames_ = 0;
};

/// Shows all of a StudySession, or of what is resumed like one.
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
                          const std::function<bool(const StudySessionState &)> &is_enough = {}) {
    session::SessionOptions options;
    options.scene = testing::assets() / "scenes" / "plate.gltf";
    options.device.file = study::device_file_of(protocol, folders);
    options.lockstep = true;
    session::Session session(options);
    MadeUpPort port(session, protocol);
    prepare(port);
    StudySessionState state;
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

/// A frame of a session, before anybody acts in it.
struct Moment {
    MadeUpPort &port;
    session::Session &session;
    const ParticipantPicture &picture;
    const StudySessionState &state;
    bool is_new_step; ///< not that of the frame before
};
using EachFrame = std::function<void(const Moment &)>;

/// Of force directions, in one block.
class StudySessionTest : public ::testing::Test {
protected:
    StudySessionTest() {
        protocol_.blocks.resize(1);
        begin_study("sitting");
    }

    void begin_study(const std::string &name) {
        folder_ = testing::fresh_folder(name);
        study::create_study(file(), {protocol_.title, "text", "0.1.0"}, study::utc_now());
        study::StudyStore(file()).add({"P01", 1, study::utc_now()});
    }

    [[nodiscard]] std::filesystem::path file() const { return folder_ / "a.study"; }

    [[nodiscard]] session::SessionOptions options() const {
        session::SessionOptions options;
        const study::Condition &first = protocol_.conditions.front();
        options.scene = first.scene == study::kNoScene ? testing::assets() / "scenes" / "plate.gltf"
                                                       : study::scene_file_of(first, folders_);
        options.device.file = study::device_file_of(protocol_, folders_);
        options.device.kind = kind_;
        for (const std::string &fault : faults_) {
            options.emulation.faults.push_back(device::parse_fault(fault));
        }
        options.starts_at_zero = starts_at_zero_;
        options.lockstep = true;
        return options;
    }

    [[nodiscard]] StudySessionPlan plan() const {
        return {protocol_,      study::study_setting(protocol_, folders_),
                folders_,       "P01",
                keeps_records_, plays_noise_};
    }

    study::SessionEnding run(const EachFrame &each_frame = {}) {
        study::StudyStore store(file());
        session::Session session(options());
        MadeUpPort port(session, protocol_);
        std::optional<StudySessionStep> before;
        port.on_frame = [&](const ParticipantPicture &picture, const StudySessionState &state) {
            const bool is_new_step = std::exchange(before, state.step) != state.step;
            if (each_frame) {
                each_frame({port, session, picture, state, is_new_step});
            }
        };
        session.start();
        StudySession study_session(store, plan(), session, port.scene_shower());
        show_to_end(study_session, port);
        steps_ = port.steps;
        return study_session.ending();
    }

    [[nodiscard]] study::StudyContents contents() const { return study::read_study(file()); }

    /// The same decisions without screens and without a device.
    [[nodiscard]] std::vector<study::Trial> headless() const {
        const auto present = [this](const study::PlannedTrial &planned) {
            study::Trial result(planned);
            const Decision decision = decision_of(planned);
            if (decision.after_s >= 0.0) {
                result.response = response_of(protocol_.task, decision.key);
            }
            return result;
        };
        return testing::conducted(protocol_, present).trials;
    }

    bool plays_noise_ = false;
    bool keeps_records_ = false;
    factory::DeviceKind kind_ = factory::DeviceKind::simulated;
    bool starts_at_zero_ = true;
    std::vector<std::string> faults_; ///< of an emulated board
    std::filesystem::path folder_;
    study::Protocol protocol_ = short_protocol("direction");
    study::ProtocolFolders folders_{testing::assets() / "protocols", testing::assets()};
    std::set<StudySessionStep> steps_; ///< of the last session
};

inline void expect_same_decisions(const std::vector<study::Trial> &seen,
                                  const std::vector<study::Trial> &requested) {
    ASSERT_EQ(seen.size(), requested.size());
    for (std::size_t i = 0; i < seen.size(); ++i) {
        testing::expect_same_decision(seen[i], requested[i]);
    }
}

/// Once, in the midst of the first presentation of the trial at that place.
class Once {
public:
    explicit Once(int position) : position_(position) {}

    [[nodiscard]] bool is_now(const StudySessionState &state) {
        const bool is_meant = !is_done_ && state.step == StudySessionStep::interval &&
                              state.phase == study::StimulusPhase::presenting && state.trial &&
                              state.trial->place.block == 1 &&
                              state.trial->place.position == position_;
        is_done_ = is_done_ || is_meant;
        return is_meant;
    }

private:
    int position_;
    bool is_done_ = false;
};

} // namespace springdrive::app::study_screen
