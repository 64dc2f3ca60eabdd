// Covers app/study/sitting/{sitting,interludes}.cpp: sessions with a questionnaire, by method of
// adjustment, and with masking noise, on a sound output that is a file, or on none.
#include "base/error_text.h"
#include "tests/app/study/made_up_people.h"
#include "tests/support/child_process.h"

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
#include <set>
#include <string>
#include <sys/stat.h>
#include <thread>
#include <unistd.h>
#include <variant>
#include <vector>

namespace springdrive::app::study_screen {
namespace {

namespace fs = std::filesystem;

using study::SessionEnding;
using study::Trial;

/// Each answer is on the disk when the next one is asked; what is missing is asked in a session of
/// its own, for which questions alone need no noise.
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
            now.port.orders.stops = text == stops_at || (stops_at == "interval" &&
                                                         now.state.step == SittingStep::interval);
            if (now.state.step != SittingStep::questionnaire) {
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
        for (const SittingStep step :
             {SittingStep::instructions, SittingStep::interval, SittingStep::over}) {
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
TEST_F(StudySitting, AnAdjustmentIsStoredAsItWasSet) {
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
            if (now.state.step != SittingStep::interval || !now.state.trial) {
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
            const double wanted =
                trial.place.position == 1 ? *trial.level * std::exp(-kSteps * step) : 0.35;
            EXPECT_NEAR(std::get<study::Adjusted>(trial.response).level, wanted, 1e-9 * wanted);
            EXPECT_TRUE(trial.marks.empty()) << trial.marks.front();
            const auto eta = std::ranges::find(trial.tuning, "eta", &study::Setting::name);
            ASSERT_NE(eta, trial.tuning.end());
            // What was felt at the end.
            EXPECT_NEAR(std::get<double>(eta->value), 0.5 + wanted, 1e-9);
        }
    }
}

/// What is played goes to a reader who stalls for a while, as an output that hangs does.
TEST_F(StudySitting, TheNoiseIsCheckedStoredAndBegunAgainWhenItHasStopped) {
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
                    was_checked || (now.state.step == SittingStep::noise_check &&
                                    now.picture.text.starts_with(protocol_.texts.noise_check));
                if (now.state.step == SittingStep::after_response && !later.joinable()) {
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

TEST_F(StudySitting, WithoutASoundOutputThereIsNoSession) {
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
