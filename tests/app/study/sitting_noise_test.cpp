// Covers app/study/sitting/sitting.cpp: a session with masking noise, on a sound output that is a
// file, or on none.
#include "base/error_text.h"
#include "tests/app/study/sitting_rig.h"
#include "tests/support/child_process.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <string>
#include <sys/stat.h>
#include <thread>
#include <unistd.h>
#include <vector>

namespace springdrive::app::study_screen {
namespace {

namespace fs = std::filesystem;

using study::SessionEnding;

constexpr const char *kSystems = "/usr/share/alsa/alsa.conf"; ///< of the package libasound2-data

/// One whose default output is a file.
void write_sound_system(const fs::path &configuration, const fs::path &played) {
    std::ofstream(configuration) << "<" << kSystems
                                 << ">\npcm.!default { type file slave.pcm \"null\" file \""
                                 << played.string() << "\" format \"raw\" }\n";
}

TEST_F(StudySitting, TheNoiseIsHeardCheckedAndStored) {
    if (!fs::exists(kSystems)) {
        GTEST_SKIP() << kSystems << " is not there";
    }
    const fs::path configuration = folder_ / "asound.conf";
    const fs::path raw = folder_ / "played.raw";
    write_sound_system(configuration, raw);
    protocol_.noise = study::MaskingNoise{-40.0};
    plays_noise_ = true;
    const std::string said = testing::said_in_child(
        [&] { setenv("ALSA_CONFIG_PATH", configuration.c_str(), 1); },
        [&] {
            ::testing::internal::CaptureStderr(); // what the sound system says of missing devices
            bool was_checked = false;
            const SessionEnding ending = run([&](MadeUpPort &port, session::Session &) {
                port.on_frame = [&](const ParticipantPicture &picture, const SittingState &state) {
                    was_checked =
                        was_checked || (state.step == SittingStep::noise_check &&
                                        picture.text.starts_with(protocol_.texts.noise_check));
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

/// What is played goes to a reader who stalls for a while, as an output that hangs does.
TEST_F(StudySitting, BeginsTheNoiseAgainThatHadStopped) {
    if (!fs::exists(kSystems)) {
        GTEST_SKIP() << kSystems << " is not there";
    }
    const fs::path configuration = folder_ / "asound.conf";
    const fs::path pipe = folder_ / "played";
    ASSERT_EQ(mkfifo(pipe.c_str(), S_IRUSR | S_IWUSR), 0);
    write_sound_system(configuration, pipe);
    protocol_.noise = study::MaskingNoise{-40.0};
    plays_noise_ = true;
    const std::string said = testing::said_in_child(
        [&] { setenv("ALSA_CONFIG_PATH", configuration.c_str(), 1); },
        [&] {
            ::testing::internal::CaptureStderr();
            std::atomic<bool> listens = true;
            std::atomic<bool> is_over = false;
            std::thread listener([&] {
                const int end = open(pipe.c_str(), O_RDWR | O_NONBLOCK);
                std::vector<char> part(4096);
                while (!is_over) {
                    if (!listens || read(end, part.data(), part.size()) <= 0) {
                        std::this_thread::sleep_for(std::chrono::milliseconds(5));
                    }
                }
                close(end);
            });
            std::thread later;
            const SessionEnding ending = run([&](MadeUpPort &port, session::Session &) {
                port.on_frame = [&](const ParticipantPicture &, const SittingState &state) {
                    if (state.step == SittingStep::after_response && !later.joinable()) {
                        listens = false;
                        std::this_thread::sleep_for(std::chrono::milliseconds(800));
                        later = std::thread([&listens] {
                            std::this_thread::sleep_for(std::chrono::milliseconds(500));
                            listens = true;
                        });
                    }
                    port.orders.stops = state.trials.size() == 2;
                };
            });
            later.join();
            is_over = true;
            listener.join();
            return std::string(name_of(ending));
        });
    EXPECT_EQ(said, "stopped");
    const std::vector<study::Note> notes = study::read_study(file()).notes;
    EXPECT_EQ(std::ranges::count(notes, "the masking noise had stopped, and was begun again",
                                 &study::Note::text),
              1);
}

TEST_F(StudySitting, QuestionsAloneNeedNoNoise) {
    protocol_.questionnaire = {{"more", study::QuestionnaireTime::after, "Anything else?"}};
    const auto session = [this](bool stops) {
        return run([stops](MadeUpPort &port, session::Session &) {
            port.on_frame = [&port, stops](const ParticipantPicture &, const SittingState &state) {
                const bool is_asked = state.step == SittingStep::questionnaire;
                port.orders.stops = stops && is_asked;
                if (is_asked) {
                    port.inputs = {MadeUpPort::key("enter", 0.0)};
                }
            };
        });
    };
    EXPECT_EQ(session(true), SessionEnding::stopped);
    protocol_.noise = study::MaskingNoise{-80.0};
    plays_noise_ = true;
    const std::string said =
        testing::said_in_child([] { setenv("ALSA_CONFIG_PATH", "/nonexistent", 1); },
                               [&] {
                                   ::testing::internal::CaptureStderr();
                                   return std::string(name_of(session(false)));
                               });
    EXPECT_EQ(said, "completed");
}

TEST_F(StudySitting, WithoutASoundOutputThereIsNoSession) {
    protocol_.noise = study::MaskingNoise{-80.0};
    plays_noise_ = true;
    const std::string said = testing::said_in_child(
        [] {},
        [&] {
            ::testing::internal::CaptureStderr();
            return error_text_of([&] {
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

} // namespace
} // namespace springdrive::app::study_screen
