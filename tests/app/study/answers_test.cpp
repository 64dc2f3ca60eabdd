// Covers how participants answer. app/study/participant/answers.cpp, and
// app/study/session/person_checks.cpp: what is drawn of the ways to answer is what they do, and
// what keeps persons out of a protocol. app/study/experimenter/live_charts.cpp: what the
// experimenter sees of the answers so far. app/study/session/{session,interludes}.cpp: sessions
// with a questionnaire, by method of adjustment, and with masking noise, on a sound output that is
// a file, or on none.
#include "app/study/experimenter/study_window.h"
#include "app/study/participant/answers.h"
#include "app/study/session/study_session.h"
#include "app/widgets/widgets.h"
#include "base/input_error.h"
#include "tests/app/study/headless_study.h"
#include "tests/app/study/made_up_people.h"
#include "tests/engine/study/protocol/plain_protocol.h"
#include "tests/support/files.h"
#include "tests/support/imgui_frame.h"

#include <fmt/core.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <set>
#include <string>
#include <sys/stat.h>
#include <thread>
#include <unistd.h>
#include <variant>
#include <vector>

namespace springdrive::app::study_screen {
namespace {

using study::ResponseDevice;
using testing::kPlainProtocol;
using testing::protocol_of;
using Keys = std::vector<std::string>;

Keys drawn(ResponseDevice device, Keys keys) {
    study::Protocol protocol = protocol_of(kPlainProtocol);
    protocol.responses = {device, std::move(keys)};
    Keys labels;
    for (const AnswerChoice &choice : choices_of(protocol)) {
        labels.push_back(choice.key);
    }
    return labels;
}

TEST(Answers, LeftIsDrawnOnTheLeftOfRight) {
    for (const ResponseDevice device :
         {ResponseDevice::keyboard, ResponseDevice::mouse, ResponseDevice::gesture}) {
        EXPECT_EQ(drawn(device, {"Right", "LEFT"}), drawn(device, {"left", "right"}));
    }
    EXPECT_EQ(drawn(ResponseDevice::keyboard, {"y", "n"}), (Keys{"Y", "N"}));
    EXPECT_EQ(drawn(ResponseDevice::keyboard, {"down", "up"}), (Keys{"↓", "↑"}));
}

TEST(Answers, ACardSaysWhatTheAnswerMeansUnlessTheKeyDoes) {
    study::Protocol protocol = protocol_of(kPlainProtocol);
    const auto meanings = [&protocol] {
        Keys texts;
        for (const AnswerChoice &choice : choices_of(protocol)) {
            texts.push_back(choice.text);
        }
        return texts;
    };
    ASSERT_EQ(protocol.task.kind, study::TaskKind::forced_choice_by_interval);
    protocol.responses.keys = {"1", "2"};
    protocol.texts.first_interval = "First";
    protocol.texts.second_interval = "2";
    EXPECT_EQ(meanings(), (Keys{"First", ""}));
    protocol.task.kind = study::TaskKind::yes_no;
    EXPECT_EQ(meanings(), (Keys{"no", "yes"}));
}

TEST(Answers, AGestureIsTheKeyAlongWhichTheTipWentFurthest) {
    constexpr double kBeyond_m = 1.01 * kGesture_m;
    constexpr double kWithin_m = 0.99 * kGesture_m;
    const Keys sides{"right", "left"};
    const Keys four{"left", "right", "towards", "away"};
    struct Case {
        ResponseDevice device;
        Keys keys;
        Vector3 moved_m;
        std::optional<std::size_t> given;
    };
    for (const Case &one : std::vector<Case>{
             {ResponseDevice::gesture, sides, {kBeyond_m, 0.0, 0.0}, 0U},
             {ResponseDevice::gesture, sides, {-kBeyond_m, 0.0, 0.0}, 1U},
             {ResponseDevice::gesture, sides, {kWithin_m, 0.0, 0.0}, std::nullopt},
             {ResponseDevice::gesture, sides, {kWithin_m, 0.1, 0.1}, std::nullopt}, // no key
             {ResponseDevice::gesture, sides, {kBeyond_m, 0.1, 0.0}, 0U},
             {ResponseDevice::gesture, four, {0.03, 0.0, 0.04}, 2U},
             {ResponseDevice::gesture, four, {0.03, 0.0, -0.025}, 1U},
             {ResponseDevice::keyboard, sides, {0.1, 0.0, 0.0}, std::nullopt}}) {
        EXPECT_EQ(alternative_of({one.device, one.keys}, one.moved_m), one.given)
            << one.moved_m.transpose();
    }
}

TEST(Answers, AClickOnACardGivesWhatItsKeyDoes) {
    study::Protocol protocol = protocol_of(kPlainProtocol);
    for (const Keys &keys : {Keys{"right", "left"}, Keys{"left", "right"}, Keys{"y", "n"},
                             Keys{"right", "left", "up"}}) {
        protocol.responses = {ResponseDevice::keyboard, keys};
        const std::vector<AnswerChoice> cards = choices_of(protocol);
        ASSERT_EQ(cards.size(), keys.size());
        const auto clicked = [&](std::size_t card) {
            return alternative_of(protocol.responses,
                                  {.source = InputSource::choice, .name = "", .choice = card});
        };
        std::vector<bool> is_reached(keys.size());
        for (std::size_t card = 0; card < cards.size(); ++card) {
            const std::size_t given = clicked(card).value();
            EXPECT_EQ(shown_key(keys.at(given), false), cards[card].key);
            is_reached[given] = true;
            EXPECT_EQ(alternative_of(protocol.responses, {.name = keys.at(given)}), given);
        }
        EXPECT_EQ(is_reached, std::vector<bool>(keys.size(), true));
        EXPECT_EQ(clicked(keys.size()), std::nullopt);
    }
}

TEST(Answers, ToQuestionsAreGivenByTheKeysOnTheirCards) {
    const study::QuestionnaireItem item{.name = "hand",
                                        .when = study::QuestionnaireTime::after,
                                        .text = "Which hand?",
                                        .kind = study::QuestionnaireKind::choice,
                                        .choices = {"right", "left"}};
    const std::vector<QuestionChoice> choices = choices_of(item, study::Texts{});
    const ParticipantPicture picture = picture_of(item, study::Texts{});
    ASSERT_EQ(choices.size(), 3U);
    ASSERT_EQ(picture.choices.size(), 3U);
    EXPECT_EQ(picture.heading, study::Texts{}.questionnaire_after);
    EXPECT_EQ(picture.text, "Which hand?");
    EXPECT_EQ(picture.choices[1], (AnswerChoice{"left", "2"}));
    EXPECT_FALSE(picture.has_text_field);
    const auto answer_by = [&](const ParticipantInput &input) {
        const QuestionChoice *const chosen = chosen_by(choices, input);
        return chosen == nullptr ? "-" : chosen->answer.value_or("none");
    };
    EXPECT_EQ(answer_by({.source = InputSource::key, .name = "2"}), "left");
    EXPECT_EQ(answer_by({.source = InputSource::key, .name = "2", .is_press = false}), "-");
    EXPECT_EQ(answer_by({.source = InputSource::key, .name = "3"}), "-");
    EXPECT_EQ(answer_by({.source = InputSource::choice, .name = "", .choice = 2}), "none");
    EXPECT_EQ(answer_by({.source = InputSource::choice, .name = "", .choice = 3}), "-");
}

/// All of its spots are tilted so far towards the user.
study::StudySetting on_slope(const study::Protocol &protocol, double degrees) {
    const double angle = degrees * std::numbers::pi / 180.0;
    study::StudySetting setting;
    setting.conditions.resize(protocol.conditions.size());
    for (study::PlacedCondition &condition : setting.conditions) {
        condition.spot.normal = {0.0, std::cos(angle), std::sin(angle)};
    }
    return setting;
}

std::string kept_out(const study::Protocol &protocol, double degrees = 0.0) {
    return validate_for_participants(protocol, on_slope(protocol, degrees));
}

std::string said_of(const study::Protocol &protocol) {
    std::string said;
    for (const study::ProtocolFinding &finding :
         check_for_persons(protocol, on_slope(protocol, 0.0))) {
        said += text_of(finding) + '\n';
    }
    return said;
}

TEST(PersonChecks, FindKeysThatNobodyCanPress) {
    study::Protocol protocol = protocol_of(kPlainProtocol);
    EXPECT_EQ(said_of(protocol), "");
    EXPECT_EQ(kept_out(protocol), "");
    protocol.responses.keys[1] = "f13";
    const std::string wrong = kept_out(protocol);
    EXPECT_TRUE(wrong.starts_with("with a person: responses.keys has \"f13\"")) << wrong;
    EXPECT_EQ(said_of(protocol), "error: " + wrong + '\n');
    protocol.responses.keys[1] = "F11";
    EXPECT_EQ(said_of(protocol), "");
}

/// A hand that leaves the surface would answer by that.
TEST(PersonChecks, FindGesturesThatLeaveTheSurface) {
    study::Protocol protocol = protocol_of(kPlainProtocol);
    protocol.responses = {ResponseDevice::gesture, {"left", "right"}};
    EXPECT_EQ(kept_out(protocol), "");
    protocol.responses.keys = {"left", "Down"};
    EXPECT_NE(kept_out(protocol).find("\"Down\", which is the way off the surface in condition \"" +
                                      protocol.conditions.front().name + "\"; take gestures"),
              std::string::npos)
        << kept_out(protocol);
    protocol.responses.keys = {"towards", "away"};
    EXPECT_EQ(kept_out(protocol, 44.0), "");
    EXPECT_NE(kept_out(protocol, 46.0), "");
    protocol.stimulus = study::StimulusForm::stroke; // in free space
    EXPECT_EQ(kept_out(protocol, 46.0), "");
    protocol.stimulus = study::StimulusForm::press;
    protocol.responses = {ResponseDevice::keyboard, {"up", "down"}};
    EXPECT_EQ(kept_out(protocol), "");
}

TEST(PersonChecks, FindWhatCannotBeAdjustedWhileItIsFelt) {
    study::Protocol protocol = protocol_of(kPlainProtocol);
    protocol.variable.parameter = "press_N";
    EXPECT_EQ(said_of(protocol), "") << "it is no adjustment";
    protocol.task.kind = study::TaskKind::adjustment;
    EXPECT_NE(kept_out(protocol).find("press_N, which cannot be adjusted"), std::string::npos);
    protocol.variable.parameter = "eta";
    EXPECT_EQ(kept_out(protocol), "");
}

/// A line of instructions takes at least 1/36 of the height, so that no more than 36 fit.
TEST(PersonChecks, FindTextsThatAreTooLongToRead) {
    study::Protocol protocol = protocol_of(kPlainProtocol);
    const auto warning = [&] {
        const std::string said = said_of(protocol);
        return said.substr(0, said.find(": does not fit"));
    };
    std::string lines = "a";
    for (int count = 1; count < 37; ++count) {
        lines += "\na";
    }
    protocol.texts.instructions = lines.substr(0, 29); // 15 lines: less than half
    EXPECT_EQ(warning(), "");
    protocol.texts.instructions = lines;
    EXPECT_EQ(warning(), "warning: texts.instructions");
    EXPECT_EQ(kept_out(protocol), "");
    protocol.texts.instructions = "a";
    protocol.questionnaire[0].text = lines;
    EXPECT_EQ(warning(), "warning: questions.hand");
}

class StudyLiveCharts : public testing::ImGuiFrame {
protected:
    StudyLiveCharts() {
        // Right above a level of 0.1, wrong below it.
        contents_ = testing::conducted(protocol_, [](const study::PlannedTrial &planned) {
            study::Trial result(planned);
            const bool is_felt = *planned.level > 0.1;
            result.response = study::Chosen{is_felt ? *planned.target : 3 - *planned.target};
            return result;
        });
    }

    /// Waits for it, as frames would.
    const study::SeriesResult *fitted(const std::string &participant, std::size_t condition) {
        fit_.request(contents_, participant, condition, study::DeviceKind::simulated);
        for (int i = 0; i < 6000 && fit_.latest() == nullptr; ++i) {
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
        }
        return fit_.latest();
    }

    /// Texts and kinds of what is drawn of it.
    std::string drawn(const study::SeriesResult &result) {
        ui::report().begin(true);
        ImGui::SetNextWindowSize({900.0F, 400.0F});
        ImGui::Begin("charts");
        draw_live_charts(protocol_, result);
        ImGui::End();
        std::string all;
        for (const ShownItem &item : ui::report().items()) {
            all += item.id + " " + item.text + "\n";
        }
        return all;
    }

    study::Protocol protocol_ =
        study::read_protocol_file(testing::assets() / "protocols" / "stiffness.toml");
    study::StudyContents contents_;
    LiveFit fit_{protocol_};
};

TEST_F(StudyLiveCharts, ShowTheCourseAndTheFunctionOfThePresentCondition) {
    const study::SeriesResult *const result = fitted("P01", 1);
    ASSERT_NE(result, nullptr);
    const auto of_condition = std::ranges::count_if(contents_.trials, [&](const auto &trial) {
        return trial.condition == protocol_.conditions[1].name && study::counts(trial);
    });
    EXPECT_EQ(std::ssize(result->trace), of_condition);
    ASSERT_TRUE(result->fitted);
    // The step of the answers at 0.1 lies between the levels of the staircase about it.
    EXPECT_GT(result->fitted->threshold.median, 0.05);
    EXPECT_LT(result->fitted->threshold.median, 0.2);
    const std::string shown = drawn(*result);
    EXPECT_NE(shown.find("levels"), std::string::npos) << shown;
    EXPECT_NE(shown.find("function"), std::string::npos) << shown;
    EXPECT_NE(shown.find(ui::formatted("threshold {:.3g}", result->fitted->threshold.median)),
              std::string::npos)
        << shown;
}

TEST_F(StudyLiveCharts, AreEmptyForWhomNothingIsStored) {
    EXPECT_EQ(fit_.latest(), nullptr);
    fit_.request(contents_, "P02", 0, study::DeviceKind::simulated);
    EXPECT_EQ(fit_.latest(), nullptr);
    fit_.request(contents_, "P01", 0, study::DeviceKind::usb); // there is none on that device
    EXPECT_EQ(fit_.latest(), nullptr);
}

namespace fs = std::filesystem;

using study::SessionEnding;
using study::Trial;

/// Each answer is on the disk when the next one is asked; what is missing is asked in a session of
/// its own, for which questions alone need no noise.
TEST_F(StudySessionTest, AsksItsQuestionsAndOnceIfTheyWereAnswered) {
    using study::QuestionnaireKind;
    using study::QuestionnaireTime;
    study::QuestionnaireItem hand{"hand", QuestionnaireTime::before, "Which hand?",
                                  QuestionnaireKind::choice};
    hand.choices = {"left", "right"};
    study::QuestionnaireItem sure{"sure", QuestionnaireTime::before, "How sure?",
                                  QuestionnaireKind::scale};
    sure.lowest = 0;
    sure.highest = 5;
    protocol_.questionnaire = {hand,
                               sure,
                               {"age", QuestionnaireTime::before, "How old?"},
                               {"more", QuestionnaireTime::after, "Anything else?"},
                               {"again", QuestionnaireTime::after, "Once more?"}};
    protocol_.practice = {};

    /// @return what was asked, and how it ended
    const auto session = [&](const std::string &stops_at) {
        std::string asked;
        std::string last;
        const SessionEnding ending = run([&](const Moment &now) {
            ParticipantInput click{.source = InputSource::choice, .name = ""};
            click.choice = now.picture.choices.size() - 1;
            const std::string &text = now.picture.text;
            now.port.orders.stops =
                text == stops_at ||
                (stops_at == "interval" && now.state.step == StudySessionStep::interval);
            if (now.state.step != StudySessionStep::questionnaire) {
                return;
            }
            asked += last == text ? "" : text + " ";
            last = text;
            if (text == "Which hand?") {
                now.port.inputs = {MadeUpPort::key("2", 0.0)};
            } else if (text == "How sure?") {
                now.port.inputs = {MadeUpPort::key("0", 0.0)};
            } else if (text == "How old?") {
                now.port.inputs = {click}; // would rather not say
            } else {
                now.port.inputs = {{.source = InputSource::letter, .name = "n"},
                                   {.source = InputSource::letter, .name = "ö"},
                                   MadeUpPort::key("enter", 0.0)};
            }
        });
        for (const StudySessionStep step :
             {StudySessionStep::instructions, StudySessionStep::interval, StudySessionStep::over}) {
            asked += steps_.contains(step) ? std::string(description(step)) + ", " : "";
        }
        return asked + std::string(name_of(ending));
    };
    EXPECT_EQ(session("interval"),
              "Which hand? How sure? How old? reads the instructions, feels, stopped");
    EXPECT_EQ(session("Once more?"), "How old? Anything else? Once more? reads the instructions, "
                                     "feels, stopped");
    const study::StudyContents before = contents();
    EXPECT_EQ(before.trials.size(), headless().size());
    EXPECT_EQ(before.answers.size(), 3U);
    protocol_.noise = study::MaskingNoise{-80.0};
    plays_noise_ = true;
    const std::string said =
        testing::said_in_child([] { setenv("ALSA_CONFIG_PATH", "/nonexistent", 1); },
                               [&] {
                                   ::testing::internal::CaptureStderr();
                                   return session("nothing");
                               });
    EXPECT_EQ(said, "Once more? is through, completed");

    const study::StudyContents after = contents();
    EXPECT_EQ(after.trials.size(), before.trials.size());
    std::string stored;
    for (const study::QuestionnaireAnswer &answer : after.answers) {
        stored += fmt::format("{} {} {}; ", answer.session, answer.item, answer.answer);
    }
    EXPECT_EQ(stored, "1 hand right; 1 sure 0; 2 more nö; 3 again nö; ");
}

/// Eta of the plate, from a drawn start, after the standard and by itself. In the first trial some
/// steps down, in the others more up than there are; one that is not ended comes again.
TEST_F(StudySessionTest, AnAdjustmentIsStoredAsItWasSet) {
    protocol_ = short_protocol("stiffness");
    study::Adjustment method;
    method.scale = study::Scale::logarithmic;
    method.minimum_start = 0.05;
    method.maximum_start = 0.15;
    method.minimum_level = 0.01;
    method.maximum_level = 0.35;
    protocol_.task.kind = study::TaskKind::adjustment;
    protocol_.practice = {};
    protocol_.responses.keys = {"left", "right", "enter"};
    protocol_.timing.presentation_s = 2.0;
    protocol_.blocks.resize(1);
    constexpr int kSteps = 7;
    const auto steps_of = [](const study::TrialPlace &place) {
        return place.position == 1 ? kSteps : 70;
    };
    for (const bool shows_standard : {true, false}) {
        SCOPED_TRACE(shows_standard ? "after the standard" : "without a standard");
        begin_study("sitting");
        protocol_.variable.shows_standard = shows_standard;
        method.settings = shows_standard ? 3 : 2;
        protocol_.method = method;
        int pressed = 0;
        std::set<std::string> headings;
        const SessionEnding ending = run([&](const Moment &now) {
            if (now.state.step != StudySessionStep::interval || !now.state.trial) {
                pressed = 0;
                return;
            }
            headings.insert(now.picture.heading);
            const study::TrialPlace &place = now.state.trial->place;
            if (now.state.interval + 1 < now.state.intervals ||
                now.state.phase != study::StimulusPhase::presenting || place.position == 2) {
                return;
            }
            if (++pressed <= steps_of(place)) {
                now.port.inputs = {MadeUpPort::key(place.position == 1 ? "left" : "right", 0.0)};
            } else if (pressed == steps_of(place) + 1) {
                now.port.inputs = {MadeUpPort::key("enter", 0.0)};
            }
        });
        EXPECT_EQ(ending, SessionEnding::completed);
        std::set<std::string> expected_headings{protocol_.texts.question};
        if (shows_standard) {
            expected_headings.insert(protocol_.texts.show_standard);
        }
        EXPECT_EQ(headings, expected_headings);
        const std::vector<Trial> trials = contents().trials;
        ASSERT_EQ(trials.size(), static_cast<std::size_t>(method.settings) + 1);
        const double step = std::log(0.35 / 0.01) / 60.0; // 60 steps from one end to the other
        for (const Trial &trial : trials) {
            SCOPED_TRACE(text_of(trial.place));
            if (trial.place.position == 2) {
                EXPECT_TRUE(std::holds_alternative<study::NoResponse>(trial.response));
                EXPECT_TRUE(trial.is_presented_again);
                continue;
            }
            ASSERT_TRUE(std::holds_alternative<study::Adjusted>(trial.response));
            const double requested =
                trial.place.position == 1 ? *trial.level * std::exp(-kSteps * step) : 0.35;
            EXPECT_NEAR(std::get<study::Adjusted>(trial.response).level, requested,
                        1e-9 * requested);
            EXPECT_TRUE(trial.marks.empty()) << trial.marks.front();
            const auto eta = std::ranges::find(trial.tuning, "eta", &study::Setting::name);
            ASSERT_NE(eta, trial.tuning.end());
            // What was felt at the end.
            EXPECT_NEAR(std::get<double>(eta->value), 0.5 + requested, 1e-9);
        }
    }
}

/// What is played goes to a reader who stalls for a while, as an output that hangs does.
TEST_F(StudySessionTest, TheNoiseIsCheckedStoredAndBegunAgainWhenItHasStopped) {
    const char *const systems = "/usr/share/alsa/alsa.conf"; // of the package libasound2-data
    if (!fs::exists(systems)) {
        GTEST_SKIP() << systems << " is not there";
    }
    const fs::path configuration = folder_ / "asound.conf";
    const fs::path pipe = folder_ / "played";
    ASSERT_EQ(mkfifo(pipe.c_str(), S_IRUSR | S_IWUSR), 0);
    std::ofstream(configuration) << fmt::format(
        "<{}>\npcm.!default {{ type file slave.pcm \"null\" file \"{}\" format \"raw\" }}\n",
        systems, pipe.string());
    protocol_.noise = study::MaskingNoise{-40.0};
    plays_noise_ = true;
    const std::string said = testing::said_in_child(
        [&] { setenv("ALSA_CONFIG_PATH", configuration.c_str(), 1); },
        [&] {
            ::testing::internal::CaptureStderr(); // what the sound system says of missing devices
            std::atomic<bool> listens = true;
            std::atomic<bool> is_over = false;
            std::atomic<long> heard = 0; // bytes
            std::thread listener([&] {
                const int end = open(pipe.c_str(), O_RDWR | O_NONBLOCK);
                std::vector<char> part(4096);
                while (!is_over) {
                    const ssize_t got = listens ? read(end, part.data(), part.size()) : 0;
                    heard += std::max<long>(got, 0);
                    if (got <= 0) {
                        std::this_thread::sleep_for(std::chrono::milliseconds(5));
                    }
                }
                close(end);
            });
            std::thread later;
            bool was_checked = false;
            const SessionEnding ending = run([&](const Moment &now) {
                was_checked =
                    was_checked || (now.state.step == StudySessionStep::noise_check &&
                                    now.picture.text.starts_with(protocol_.texts.noise_check));
                if (now.state.step == StudySessionStep::after_response && !later.joinable()) {
                    listens = false;
                    std::this_thread::sleep_for(std::chrono::milliseconds(800));
                    later = std::thread([&listens] {
                        std::this_thread::sleep_for(std::chrono::milliseconds(500));
                        listens = true;
                    });
                }
                now.port.orders.stops = now.state.trials.size() == 2;
            });
            later.join();
            is_over = true;
            listener.join();
            return fmt::format("{}, {}, {}", was_checked ? "checked" : "not checked",
                               heard > 0 ? "heard" : "silent", name_of(ending));
        });
    EXPECT_EQ(said, "checked, heard, stopped");
    const study::StudyContents stored = contents();
    EXPECT_EQ(std::ranges::count(stored.notes, "the masking noise had stopped, and was begun again",
                                 &study::Note::text),
              1);
    const std::vector<study::Setting> &facts = stored.sessions.at(0).facts;
    EXPECT_EQ(std::ranges::count(facts, study::Setting{"noise_level_dBFS", -40.0}), 1);
    EXPECT_EQ(std::ranges::count(facts, study::Setting{"noise_output", std::string("default")}), 1);
}

TEST_F(StudySessionTest, WithoutASoundOutputThereIsNoSession) {
    protocol_.noise = study::MaskingNoise{-80.0};
    plays_noise_ = true;
    const std::string said = testing::said_in_child(
        [] {},
        [&] {
            ::testing::internal::CaptureStderr();
            return error_text_of([&] {
                static_cast<void>(run([](const Moment &now) { now.port.orders.stops = true; }));
            });
        });
    if (said.empty()) {
        GTEST_SKIP() << "this machine has a sound output";
    }
    EXPECT_NE(said.find("there is no sound output"), std::string::npos) << said;
    EXPECT_TRUE(contents().sessions.empty());
}

} // namespace
} // namespace springdrive::app::study_screen
