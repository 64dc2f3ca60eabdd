// Covers app/study/{sitting,trial_presenter,answers}.cpp: whole sessions on the simulated device,
// in lockstep, with a participant and an experimenter that are made up. See study_window_test.cpp
// for the real windows.
#include "app/study/sitting.h"

#include "app/study/answers.h"
#include "base/complaint.h"
#include "base/input_error.h"
#include "engine/study/protocol/protocol_file.h"
#include "tests/app/study/headless_study.h"
#include "tests/app/study/made_up_people.h"
#include "tests/support/child_process.h"
#include "tests/support/devices.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace springdrive::app::study_screen {
namespace {

namespace fs = std::filesystem;

using study::PlannedTrial;
using study::SessionEnding;
using study::Trial;

class StudySitting : public ::testing::Test {
protected:
    explicit StudySitting(const std::string &protocol = "direction")
        : folder_(testing::fresh_folder("sitting")),
          protocol_(short_protocol(protocol)), folders_{testing::assets() / "protocols",
                                                        testing::assets()} {
        study::create_study(file(), {protocol_.title, "text", "0.1.0"}, study::utc_now());
        study::StudyStore(file()).add({"P01", 1, study::utc_now()});
    }

    [[nodiscard]] fs::path file() const { return folder_ / "a.study"; }

    [[nodiscard]] session::SessionOptions options() const {
        session::SessionOptions options;
        options.scene = study::scene_file_of(protocol_.conditions.front(), folders_);
        options.device.file = study::device_file_of(protocol_, folders_);
        options.device.kind = kind_;
        options.starts_at_zero = kind_ == factory::DeviceKind::emulated;
        options.lockstep = true;
        return options;
    }

    [[nodiscard]] SittingPlan plan() const {
        return {protocol_,   study::study_setting(protocol_, folders_), folders_, "P01", false,
                plays_noise_};
    }

    SessionEnding run(const std::function<void(MadeUpPort &, session::Session &)> &prepare = {}) {
        study::StudyStore store(file());
        session::Session session(options());
        MadeUpPort port(session, protocol_);
        if (prepare) {
            prepare(port, session);
        }
        session.start();
        Sitting sitting(store, plan(), session, port);
        const SessionEnding ending = sitting.run();
        steps_ = port.steps;
        return ending;
    }

    /// The same decisions without screens and without a device.
    [[nodiscard]] std::vector<Trial> headless() const {
        const auto present = [this](const PlannedTrial &planned) {
            study::TrialResult result;
            const Decision decision = decision_of(planned);
            if (decision.after_s >= 0.0) {
                result.response = response_of(protocol_.task, decision.key);
            }
            return result;
        };
        return testing::conducted(protocol_, present).trials;
    }

    bool plays_noise_ = false;
    factory::DeviceKind kind_ = factory::DeviceKind::simulated;
    fs::path folder_;
    study::Protocol protocol_;
    study::ProtocolFolders folders_;
    std::set<SittingStep> steps_;
};

void expect_same_decisions(const std::vector<Trial> &seen, const std::vector<Trial> &wanted) {
    ASSERT_EQ(seen.size(), wanted.size());
    for (std::size_t i = 0; i < seen.size(); ++i) {
        SCOPED_TRACE(text_of(wanted[i].place));
        EXPECT_EQ(seen[i].place, wanted[i].place);
        EXPECT_EQ(seen[i].condition, wanted[i].condition);
        EXPECT_EQ(seen[i].level, wanted[i].level);
        EXPECT_EQ(seen[i].target, wanted[i].target);
        EXPECT_EQ(seen[i].seed, wanted[i].seed);
        EXPECT_EQ(seen[i].response, wanted[i].response);
        EXPECT_EQ(seen[i].is_correct, wanted[i].is_correct);
        EXPECT_EQ(seen[i].repetition_of, wanted[i].repetition_of);
        EXPECT_EQ(seen[i].marks, wanted[i].marks);
    }
}

TEST_F(StudySitting, StoresWhatTheSameDecisionsGiveHeadless) {
    const SessionEnding ending = run();
    EXPECT_EQ(ending, SessionEnding::completed);
    const std::vector<Trial> trials = study::read_study(file()).trials;
    expect_same_decisions(trials, headless());
    for (const SittingStep step :
         {SittingStep::instructions, SittingStep::practice_begins, SittingStep::practice_ends,
          SittingStep::in_break, SittingStep::interval, SittingStep::response, SittingStep::over}) {
        EXPECT_TRUE(steps_.contains(step)) << description(step);
    }
    for (const Trial &trial : trials) {
        ASSERT_EQ(trial.presentations.size(), 2U);
        if (trial.response_time_s) {
            // The question comes when the hand has left, at most half a second after the end.
            EXPECT_GE(*trial.response_time_s, 0.3);
            EXPECT_LE(*trial.response_time_s, 1.0);
        }
    }
}

/// Once, in the midst of the first presentation of the trial at that place.
class Once {
public:
    explicit Once(int position) : position_(position) {}

    [[nodiscard]] bool is_now(const SittingState &state) {
        const bool is_meant = !is_done_ && state.step == SittingStep::interval &&
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

TEST_F(StudySitting, ATripIsStoredAndItsTrialComesAgain) {
    Once once(3);
    std::string shown;
    const SessionEnding ending = run([&](MadeUpPort &port, session::Session &session) {
        port.on_frame = [&](const ParticipantPicture &picture, const SittingState &state) {
            if (once.is_now(state)) {
                session.servo().emergency_stop();
            }
            if (state.step == SittingStep::device_stopped) {
                shown = picture.text;
                port.orders.resets_device = true;
            }
        };
    });
    EXPECT_EQ(ending, SessionEnding::completed);
    EXPECT_EQ(shown, protocol_.texts.device_stopped);
    const std::vector<Trial> trials = study::read_study(file()).trials;
    const auto tripped = std::ranges::find_if(
        trials, [](const Trial &trial) { return !trial.safety_events.empty(); });
    ASSERT_NE(tripped, trials.end());
    EXPECT_EQ(tripped->place.position, 3);
    EXPECT_TRUE(std::holds_alternative<study::NoResponse>(tripped->response));
    EXPECT_TRUE(tripped->is_presented_again);
    EXPECT_EQ(
        std::ranges::count_if(
            trials, [&](const Trial &trial) { return trial.repetition_of == tripped->place; }),
        1);
}

TEST_F(StudySitting, AStopByHandWaitsForTheExperimenter) {
    Once once(2);
    int frames_stopped = 0;
    run([&](MadeUpPort &port, session::Session &session) {
        port.on_frame = [&](const ParticipantPicture &, const SittingState &state) {
            if (once.is_now(state)) {
                session.servo().emergency_stop();
            }
            // Ten seconds, three times what another stop takes to be reset.
            if (state.step == SittingStep::device_stopped && ++frames_stopped == 600) {
                port.orders.stops = true;
            }
        };
    });
    EXPECT_EQ(frames_stopped, 600);
    EXPECT_EQ(study::read_study(file()).sessions.front().ending, SessionEnding::stopped);
}

void set_plugged(session::Session &session, bool is_plugged) {
    session.servo().paused([&] { session.device().emulated()->set_plugged(is_plugged); });
}

TEST_F(StudySitting, ATrialInWhichTheCableIsPulledBeginsAnew) {
    kind_ = factory::DeviceKind::emulated;
    Once once(3);
    int lost = 0;
    const SessionEnding ending = run([&](MadeUpPort &port, session::Session &session) {
        port.on_frame = [&](const ParticipantPicture &, const SittingState &state) {
            if (once.is_now(state)) {
                set_plugged(session, false);
            }
            if (state.step == SittingStep::device_lost && ++lost == 60) {
                set_plugged(session, true);
            }
        };
    });
    EXPECT_GE(lost, 60);
    EXPECT_EQ(ending, SessionEnding::completed);
    expect_same_decisions(study::read_study(file()).trials, headless());
}

TEST_F(StudySitting, GoesOnAfterAStopAsIfUndisturbed) {
    for (const int position : {2, 3}) {
        Once once(position);
        const SessionEnding ending = run([&](MadeUpPort &port, session::Session &) {
            port.on_frame = [&](const ParticipantPicture &, const SittingState &state) {
                port.orders.stops = once.is_now(state);
            };
        });
        EXPECT_EQ(ending, SessionEnding::stopped);
    }
    EXPECT_EQ(run(), SessionEnding::completed);
    EXPECT_EQ(study::read_study(file()).sessions.size(), 3U);
    expect_same_decisions(study::read_study(file()).trials, headless());
}

TEST_F(StudySitting, PausesBreaksAndRepeatsAsTheExperimenterWants) {
    Once pauses(2);
    Once repeats(4);
    Once breaks(5);
    int paused = 0;
    int in_break = 0;
    int break_of = 0;
    const SessionEnding ending = run([&](MadeUpPort &port, session::Session &) {
        port.on_frame = [&](const ParticipantPicture &, const SittingState &state) {
            if (pauses.is_now(state)) {
                port.orders.is_paused = true;
            }
            if (state.step == SittingStep::paused && ++paused == 120) {
                port.orders.is_paused = false;
            }
            port.orders.repeats = port.orders.repeats || repeats.is_now(state);
            if (breaks.is_now(state)) {
                port.orders.skips_to_break = true;
                in_break = 0;
                break_of = 1;
            }
            if (state.step == SittingStep::in_break && break_of == 1) {
                ++in_break;
            }
            if (state.trial && state.trial->place.position == 6) {
                break_of = 2;
            }
        };
    });
    EXPECT_EQ(ending, SessionEnding::completed);
    EXPECT_EQ(paused, 120);
    EXPECT_GE(in_break, 59); // a second
    const std::vector<Trial> trials = study::read_study(file()).trials;
    const auto repeated = std::ranges::find_if(trials, [](const Trial &trial) {
        return std::ranges::count(trial.marks, "repeated at the experimenter's wish") > 0;
    });
    ASSERT_NE(repeated, trials.end());
    EXPECT_EQ(repeated->place.position, 4);
    EXPECT_TRUE(repeated->is_presented_again);
}

TEST_F(StudySitting, PractisesAgainUntilItIsUnderstood) {
    int begun = 0;
    int asked_in_practice = 0;
    SittingStep before = SittingStep::over;
    const SessionEnding ending = run([&](MadeUpPort &port, session::Session &) {
        port.on_frame = [&](const ParticipantPicture &picture, const SittingState &state) {
            if (state.step == SittingStep::practice_ends && before != state.step) {
                EXPECT_EQ(picture.text, "Press 1 to practise again, 2 to begin.");
                if (++begun <= 2) { // twice
                    port.inputs = {MadeUpPort::key("1", 0.0)};
                }
            }
            if (state.step == SittingStep::response && before != state.step && begun <= 2 &&
                state.trial->presented.kind == study::TrialKind::practice) {
                ++asked_in_practice;
            }
            before = state.step;
        };
    });
    EXPECT_EQ(ending, SessionEnding::completed);
    EXPECT_GE(begun, 3);
    EXPECT_EQ(asked_in_practice, 3 * protocol_.practice.fewest_trials);
    const study::StudyContents contents = study::read_study(file());
    expect_same_decisions(contents.trials, headless()); // the sequence knows nothing of it
    ASSERT_EQ(contents.notes.size(), 2U);
    EXPECT_EQ(contents.notes[0].text, "practised 2 trials again, which are not stored");
}

/// By method of adjustment: eta of the plate, from a drawn start.
study::Protocol adjusting_protocol() {
    study::Protocol protocol = short_protocol("stiffness");
    study::Adjustment method;
    method.scale = study::Scale::logarithmic;
    method.minimum_start = 0.05;
    method.maximum_start = 0.15;
    method.minimum_level = 0.01;
    method.maximum_level = 0.35;
    method.settings = 2;
    protocol.method = method;
    protocol.task.kind = study::TaskKind::adjustment;
    protocol.practice = {};
    protocol.responses.keys = {"left", "right", "enter"};
    protocol.timing.presentation_s = 3.0;
    protocol.blocks.resize(1);
    return protocol;
}

TEST_F(StudySitting, AnAdjustmentIsStoredAsItWasSet) {
    protocol_ = adjusting_protocol();
    constexpr int kSteps = 7;
    const auto is_first = [](const SittingState &state) {
        return state.trial->place.position == 1;
    };
    int pressed = 0;
    const SessionEnding ending = run([&](MadeUpPort &port, session::Session &) {
        port.on_frame = [&](const ParticipantPicture &, const SittingState &state) {
            if (state.step != SittingStep::interval || !state.trial) {
                pressed = 0;
                return;
            }
            if (state.interval + 1 < state.intervals ||
                state.phase != study::StimulusPhase::presenting) {
                return;
            }
            // In the first trial less, in the others more, and beyond the end of the reach.
            const int steps = is_first(state) ? kSteps : 70;
            if (++pressed <= steps) {
                port.inputs = {MadeUpPort::key(is_first(state) ? "left" : "right", 0.0)};
            } else if (pressed == steps + 1) {
                port.inputs = {MadeUpPort::key("enter", 0.0)};
            }
        };
    });
    EXPECT_EQ(ending, SessionEnding::completed);
    const std::vector<Trial> trials = study::read_study(file()).trials;
    ASSERT_EQ(trials.size(), 2U);
    const double step = std::log(0.35 / 0.01) / 60.0; // 60 steps from one end to the other
    for (const Trial &trial : trials) {
        SCOPED_TRACE(text_of(trial.place));
        ASSERT_TRUE(std::holds_alternative<study::Adjusted>(trial.response));
        const double wanted =
            trial.place.position == 1 ? *trial.level * std::exp(-kSteps * step) : 0.35;
        EXPECT_NEAR(std::get<study::Adjusted>(trial.response).level, wanted, 1e-9 * wanted);
        EXPECT_TRUE(trial.marks.empty()) << trial.marks.front();
        const auto eta = std::ranges::find(trial.tuning, "eta", &study::Setting::name);
        ASSERT_NE(eta, trial.tuning.end());
        EXPECT_NEAR(std::get<double>(eta->value), 0.5 + wanted, 1e-9); // what was felt at the end
    }
}

TEST_F(StudySitting, AnAdjustmentThatIsNotEndedComesAgain) {
    protocol_ = adjusting_protocol();
    protocol_.timing.presentation_s = 1.0;
    const SessionEnding ending = run([&](MadeUpPort &port, session::Session &) {
        port.on_frame = [&](const ParticipantPicture &, const SittingState &state) {
            if (state.step == SittingStep::interval && state.trial->place.position > 1) {
                port.inputs = {MadeUpPort::key("enter", 0.0)};
            }
        };
    });
    EXPECT_EQ(ending, SessionEnding::completed);
    const std::vector<Trial> trials = study::read_study(file()).trials;
    ASSERT_EQ(trials.size(), 3U);
    EXPECT_TRUE(std::holds_alternative<study::NoResponse>(trials[0].response));
    EXPECT_TRUE(trials[0].is_presented_again);
    EXPECT_EQ(std::get<study::Adjusted>(trials[1].response).level, *trials[1].level);
}

constexpr const char *kSystems = "/usr/share/alsa/alsa.conf"; ///< of the package libasound2-data

TEST_F(StudySitting, TheNoiseIsHeardCheckedAndStored) {
    if (!fs::exists(kSystems)) {
        GTEST_SKIP() << kSystems << " is not there";
    }
    const fs::path configuration = folder_ / "asound.conf";
    const fs::path raw = folder_ / "played.raw";
    std::ofstream(configuration) << "<" << kSystems
                                 << ">\npcm.!default { type file slave.pcm \"null\" file \""
                                 << raw.string() << "\" format \"raw\" }\n";
    protocol_.noise = study::MaskingNoise{-40.0};
    plays_noise_ = true;
    const std::string said = testing::said_in_child(
        [&] { setenv("ALSA_CONFIG_PATH", configuration.c_str(), 1); },
        [&] {
            ::testing::internal::CaptureStderr(); // what the sound system says of missing devices
            bool was_checked = false;
            const SessionEnding ending = run([&](MadeUpPort &port, session::Session &) {
                port.on_frame = [&](const ParticipantPicture &picture, const SittingState &state) {
                    was_checked = was_checked || (state.step == SittingStep::noise_check &&
                                                  picture.text == protocol_.texts.noise_check);
                    port.orders.stops = state.step == SittingStep::interval;
                };
            });
            return std::string(was_checked ? "checked, " : "not checked, ") +
                   std::string(name_of(ending));
        });
    EXPECT_EQ(said, "checked, stopped");
    EXPECT_GT(fs::file_size(raw), 0U);
    const std::vector<study::Setting> facts = study::read_study(file()).sessions.at(0).facts;
    EXPECT_EQ(std::ranges::count(facts, study::Setting{"noise_level_dBFS", -40.0}), 1);
    EXPECT_EQ(std::ranges::count(facts, study::Setting{"noise_output", std::string("default")}), 1);
}

TEST_F(StudySitting, WithoutASoundOutputThereIsNoSession) {
    protocol_.noise = study::MaskingNoise{-80.0};
    plays_noise_ = true;
    const std::string said = testing::said_in_child(
        [] {},
        [&] {
            ::testing::internal::CaptureStderr();
            return complaint_of([&] {
                static_cast<void>(
                    run([](MadeUpPort &port, session::Session &) { port.orders.stops = true; }));
            });
        });
    if (said.empty()) {
        GTEST_SKIP() << "this machine has a sound output";
    }
    EXPECT_NE(said.find("there is no sound output"), std::string::npos) << said;
    EXPECT_TRUE(study::read_study(file()).sessions.empty());
}

TEST_F(StudySitting, AStandardThatIsPresentedFirstIsCalledThat) {
    protocol_ = adjusting_protocol();
    protocol_.variable.shows_standard = true;
    std::set<std::string> headings;
    run([&](MadeUpPort &port, session::Session &) {
        port.on_frame = [&](const ParticipantPicture &picture, const SittingState &state) {
            if (state.step == SittingStep::interval) {
                headings.insert(picture.heading);
            }
            port.orders.stops = state.step == SittingStep::after_response;
            if (state.interval == 1 && state.phase == study::StimulusPhase::presenting) {
                port.inputs = {MadeUpPort::key("enter", 0.0)};
            }
        };
    });
    EXPECT_EQ(headings,
              (std::set<std::string>{protocol_.texts.show_standard, protocol_.texts.question}));
}

ParticipantInput letter(const std::string &text) {
    ParticipantInput input;
    input.source = InputSource::letter;
    input.name = text;
    return input;
}

ParticipantInput click(std::size_t choice) {
    ParticipantInput input;
    input.source = InputSource::choice;
    input.choice = choice;
    return input;
}

TEST_F(StudySitting, AsksItsQuestionsAndOnceIfTheyWereAnswered) {
    using study::QuestionnaireKind;
    using study::QuestionnaireTime;
    study::QuestionnaireItem hand{"hand", QuestionnaireTime::before, "Which hand?",
                                  QuestionnaireKind::choice};
    hand.choices = {"left", "right"};
    study::QuestionnaireItem sure{"sure", QuestionnaireTime::before, "How sure?",
                                  QuestionnaireKind::scale};
    sure.lowest = 0;
    sure.highest = 5;
    const study::QuestionnaireItem age{"age", QuestionnaireTime::before, "How old?"};
    const study::QuestionnaireItem more{"more", QuestionnaireTime::after, "Anything else?"};
    protocol_.questionnaire = {hand, sure, age, more};

    std::vector<std::string> asked;
    const auto answers = [&asked](MadeUpPort &port, bool stops) {
        port.on_frame = [&asked, &port, stops](const ParticipantPicture &picture,
                                               const SittingState &state) {
            port.orders.stops = stops && state.step == SittingStep::interval;
            if (state.step != SittingStep::questionnaire) {
                return;
            }
            if (asked.empty() || asked.back() != picture.text) {
                asked.push_back(picture.text);
            }
            if (picture.text == "Which hand?") {
                port.inputs = {MadeUpPort::key("2", 0.0)};
            } else if (picture.text == "How sure?") {
                port.inputs = {MadeUpPort::key("0", 0.0)};
            } else if (picture.text == "How old?") {
                port.inputs = {click(picture.choices.size() - 1)}; // would rather not say
            } else {
                port.inputs = {letter("n"), letter("ö"), MadeUpPort::key("enter", 0.0)};
            }
        };
    };
    EXPECT_EQ(run([&](MadeUpPort &port, session::Session &) { answers(port, true); }),
              SessionEnding::stopped);
    EXPECT_EQ(asked, (std::vector<std::string>{"Which hand?", "How sure?", "How old?"}));
    asked.clear();
    EXPECT_EQ(run([&](MadeUpPort &port, session::Session &) { answers(port, false); }),
              SessionEnding::completed);
    EXPECT_EQ(asked, (std::vector<std::string>{"How old?", "Anything else?"}));

    const std::vector<study::QuestionnaireAnswer> stored = study::read_study(file()).answers;
    ASSERT_EQ(stored.size(), 3U);
    EXPECT_EQ(stored[0].answer, "right");
    EXPECT_EQ(stored[1].answer, "0");
    EXPECT_EQ(stored[2].answer, "nö");
    EXPECT_EQ(stored[2].session, 2);
}

TEST_F(StudySitting, AParticipantWhoLeavesIsStoredAsThat) {
    Once once(1);
    const SessionEnding ending = run([&](MadeUpPort &port, session::Session &) {
        port.on_frame = [&](const ParticipantPicture &, const SittingState &state) {
            port.orders.participant_leaves = once.is_now(state);
        };
    });
    EXPECT_EQ(ending, SessionEnding::left);
    EXPECT_TRUE(study::read_study(file()).trials.empty());
}

/// All that a participant sees of the first interval until the hand leaves.
std::vector<ParticipantPicture> pictures_of_first_interval(const study::Protocol &protocol,
                                                           const study::ProtocolFolders &folders,
                                                           const PlannedTrial &planned) {
    std::vector<ParticipantPicture> pictures;
    present_alone(protocol, folders, planned, [&](MadeUpPort &port) {
        port.on_frame = [&](const ParticipantPicture &picture, const SittingState &state) {
            if (state.step != SittingStep::interval || state.interval != 0) {
                return;
            }
            if (state.phase == study::StimulusPhase::leaving) {
                EXPECT_EQ(picture, pictures.back()); // for as long as a hand was deep
            } else {
                pictures.push_back(picture);
            }
        };
    });
    return pictures;
}

TEST(StudyPictures, AreTheSameOfEachConditionAndLevelUntilTheHandLeaves) {
    const study::ProtocolFolders folders{testing::assets() / "protocols", testing::assets()};
    for (const char *name : {"direction", "stiffness", "blow", "hardness", "mass"}) {
        SCOPED_TRACE(name);
        study::Protocol protocol = study::read_protocol_file(testing::assets() / "protocols" /
                                                             (std::string(name) + ".toml"));
        protocol.timing.response_s = 1.0;
        const std::vector<double> levels = study::presentable_levels(protocol);
        std::vector<ParticipantPicture> first;
        for (const PlannedTrial &planned :
             trials_of_conditions(protocol, {levels.front(), levels.back()}, {0, 1})) {
            SCOPED_TRACE(::testing::Message() << protocol.conditions[planned.condition].name
                                              << " at " << planned.presented.level);
            const std::vector<ParticipantPicture> pictures =
                pictures_of_first_interval(protocol, folders, planned);
            EXPECT_GT(pictures.size(), 10U);
            if (first.empty()) {
                first = pictures;
            }
            ASSERT_EQ(pictures.size(), first.size());
            for (std::size_t i = 0; i < pictures.size(); ++i) {
                ASSERT_EQ(pictures[i], first[i]) << "frame " << i;
            }
        }
    }
}

} // namespace
} // namespace springdrive::app::study_screen
