// An exhibit under a visitor who does everything wrong: random keys, drags, drops, clicks and
// stops, while its device's cable is pulled again and again. The default tests run a sample;
// `tests/long kiosk` two hours, or SPRINGDRIVE_KIOSK_SECONDS of them.
#include "app/exhibit/tour.h"
#include "app/exhibit/trip_recovery.h"
#include "engine/record/record_file.h"
#include "engine/servo/safety_status.h"
#include "tests/support/cases.h"
#include "tests/support/devices.h"
#include "tests/support/files.h"
#include "tests/support/shown_window.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <random>
#include <regex>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

namespace springdrive::app {
namespace {

using testing::Report;
using testing::ShownWindow;

constexpr std::uint64_t kSeed = 1;

/// From the last thing that the visitor did, or from the plugging in, to running motors: a person
/// lets it go on, the lift of the tip, the rest and the gains' second; twice, as the cable may be
/// pulled meanwhile (4 s at the most).
constexpr double kRecovered_s = 45.0;

// Of the memory: every scene was shown twice before the storm, and the telemetry is full by the end
// of the first span; from then on the largest of each span must not grow.
constexpr double kWarmUp_s = 300.0;
constexpr double kSpan_s = 120.0;
constexpr double kCourse_s = 600.0;
constexpr double kGrowth_MiB = 16.0;

double storm_seconds() {
    const char *const typed =
        std::getenv("SPRINGDRIVE_KIOSK_SECONDS"); // NOLINT(concurrency-mt-unsafe)
    return typed != nullptr ? std::stod(typed) : testing::cases(15, 7200);
}

double memory_MiB(pid_t process) {
    std::ifstream file("/proc/" + std::to_string(process) + "/status");
    for (std::string line; std::getline(file, line);) {
        if (line.starts_with("VmRSS:")) {
            return std::stod(line.substr(6)) / 1024.0;
        }
    }
    return std::numeric_limits<double>::quiet_NaN();
}

class Storm {
public:
    explicit Storm(double seconds)
        : seconds_(seconds), folder_(testing::fresh_folder("kiosk_storm")),
          window_(arguments(), {1280, 720, 1.0, false}, folder_, testing::Pace::clock) {
        std::ofstream(folder_ / "own.csv") << "t,x,y,z\n0,0,0.05,0\n1,0,0.05,0\n";
        std::ofstream(folder_ / "broken.gltf") << "{";
    }

    void run() {
        if (measures_memory()) {
            show_all_scenes();
        }
        start_ = Clock::now();
        while (passed_s() < seconds_ && !::testing::Test::HasFailure()) {
            rage(std::uniform_real_distribution(3.0, 20.0)(random_));
            expect_alive();
            let_heal();
        }
        const testing::Ending ending = window_.program().end(SIGTERM);
        EXPECT_EQ(ending.exit_status, 0) << ending.error;
    }

    void expect_flat_memory() const {
        if (!measures_memory()) {
            return;
        }
        EXPECT_LT(last_MiB_ - warm_MiB_, kGrowth_MiB);
        std::printf("worst memory: %.0f MiB at the end, %.0f MiB after the warm-up; every ten "
                    "minutes:",
                    last_MiB_, warm_MiB_);
        for (const double each_MiB : course_MiB_) {
            std::printf(" %.0f", each_MiB);
        }
        std::printf("\n");
    }

    /// The log's last line.
    [[nodiscard]] std::string summary() const {
        std::istringstream log(testing::contents_of(folder_ / "day.log"));
        std::string last;
        for (std::string line; std::getline(log, line);) {
            last = line;
        }
        return last;
    }
    [[nodiscard]] double summed(const std::string &before) const {
        const std::string text = summary();
        const std::size_t at = text.find(before);
        EXPECT_NE(at, std::string::npos) << text;
        return at == std::string::npos ? -1.0 : std::stod(text.substr(at + before.size()));
    }
    /// Each stop is recovered, those before the last with it, if the motors had not run in between.
    void expect_healed() const {
        const std::regex stops(R"((\d+) stops?(?: \((\d+) while healing\))?, (\d+) healed)");
        const std::string text = summary();
        std::smatch found;
        ASSERT_TRUE(std::regex_search(text, found, stops)) << text;
        const int while_recovery = found[2].matched ? std::stoi(found[2]) : 0;
        EXPECT_EQ(std::stoi(found[1]) - while_recovery, std::stoi(found[3])) << text;
    }
    [[nodiscard]] std::filesystem::path record() const { return folder_ / "storm.rec"; }
    [[nodiscard]] bool has_record() const { return seconds_ <= 60.0; } // 1 MB a second

    void print() const {
        std::printf("counts: %.0f s, %d acts, %d rounds, worst healing %.1f s after the visitor; "
                    "%s\n",
                    seconds_, acts_, rounds_, worst_recovery_s_, summary().c_str());
    }

private:
    using Clock = std::chrono::steady_clock;

    /// Of a sample nothing can be said.
    [[nodiscard]] bool measures_memory() const { return seconds_ >= kWarmUp_s + 2.0 * kSpan_s; }

    void show_all_scenes() {
        window_.wait_until([](const Report &report) { return report.shows("Touch to begin"); },
                           "it attracts");
        window_.person().click(640.0F, 360.0F);
        for (std::size_t i = 0; i < 2 * exhibit::kTour.size(); ++i) {
            show_next_scene();
        }
    }

    /// Clicks again where a message moved the button from under the mouse.
    void show_next_scene() {
        const double before = window_.look().column("scene_id");
        const auto has_changed = [&] { return window_.look().column("scene_id") != before; };
        const Clock::time_point begin = Clock::now();
        while (!has_changed()) {
            ASSERT_LT(Clock::now() - begin, std::chrono::duration<double>(kRecovered_s));
            window_.click("choices/next scene");
            for (int i = 0; i < 50 && !has_changed(); ++i) {
                std::this_thread::sleep_for(std::chrono::milliseconds(100));
            }
        }
    }

    [[nodiscard]] double passed_s() const {
        return std::chrono::duration<double>(Clock::now() - start_).count();
    }

    std::vector<std::string> arguments() {
        std::vector<std::string> all{"--kiosk", "--log", folder_ / "day.log", "--device",
                                     "emulated"};
        if (has_record()) {
            all.insert(all.end(), {"--record", record()});
        }
        double at_s = 5.0; // by the board's clock
        while (at_s < seconds_) {
            const double out_s = std::uniform_real_distribution(0.1, 4.0)(random_);
            all.insert(all.end(),
                       {"--fault", fmt::format("unplug@{:.2f}-{:.2f}", at_s, at_s + out_s)});
            at_s += out_s + std::uniform_real_distribution(20.0, 150.0)(random_);
        }
        return all;
    }

    [[nodiscard]] int upto(int most) { return std::uniform_int_distribution(0, most)(random_); }
    testing::Point anywhere() {
        return {static_cast<float>(upto(1279)), static_cast<float>(upto(719))};
    }

    void rage(double seconds) {
        const double end_s = passed_s() + seconds;
        while (passed_s() < end_s) {
            act();
            ++acts_;
        }
    }

    void act() {
        testing::Person &person = window_.person();
        const testing::Point place = anywhere();
        const int what = upto(99);
        if (what < 30) {
            person.key(random_key());
        } else if (what < 65) {
            person.drag(place, anywhere(), std::uniform_real_distribution(0.05, 0.8)(random_),
                        upto(3) == 0 ? 1 + upto(2) : 1);
        } else if (what < 72) {
            person.click(place.x, place.y, 1 + upto(2));
        } else if (what < 80) { // the row of the exhibit's own buttons
            constexpr float kRow = 668.0F;
            person.click(static_cast<float>(600 + upto(650)), kRow);
        } else if (what < 88) {
            person.wheel(place.x, place.y, upto(10) - 5);
        } else if (what < 92) {
            person.drop_files(place.x, place.y, {random_file()});
        } else if (what < 95) {
            person.close_window();
        } else if (what < 97) {
            person.key(upto(1) == 0 ? "F12" : "space");
        } else {
            std::this_thread::sleep_for(std::chrono::milliseconds(upto(1500)));
        }
    }

    std::string random_key() {
        static const std::array<const char *, 44> kKeys{
            "a",      "b",      "d",   "e",    "f",     "h",    "i",     "j",      "k",
            "l",      "m",      "m",   "n",    "o",     "p",    "q",     "r",      "s",
            "t",      "u",      "w",   "z",    "0",     "1",    "9",     "period", "comma",
            "minus",  "plus",   "F1",  "F2",   "F5",    "F6",   "F9",    "F10",    "F11",
            "Escape", "Return", "Tab", "Left", "Right", "Home", "Prior", "Next"};
        static const std::array<const char *, 6> kHeld{"", "", "", "ctrl+", "alt+", "shift+"};
        return std::string(kHeld[static_cast<std::size_t>(upto(5))]) +
               kKeys[static_cast<std::size_t>(upto(43))];
    }

    std::filesystem::path random_file() {
        const std::array<std::filesystem::path, 4> files{testing::assets() / "scenes/slope.gltf",
                                                         folder_ / "own.csv",
                                                         folder_ / "broken.gltf", folder_};
        return files[static_cast<std::size_t>(upto(3))];
    }

    void expect_alive() {
        const Report report = window_.look();
        const auto frame = report.all().at("window").at("frame").get<std::uint64_t>();
        EXPECT_GT(frame, frame_);
        frame_ = frame;
        EXPECT_EQ(report.all().at("window").at("width"), 1280);
        EXPECT_NE(report.find("stop/stop"), nullptr) << report.texts();
        EXPECT_EQ(report.find("window/menu"), nullptr) << report.texts();
        for (const servo::SafetyLimit &limit : servo::kSafetyLimits) {
            EXPECT_LE(report.column(std::string("limit_") + limit.name),
                      exhibit::kiosk_limits().*limit.value)
                << limit.name;
        }
        note_memory();
    }

    void note_memory() {
        const double now_MiB = memory_MiB(window_.program().process());
        if (passed_s() >= kCourse_s * static_cast<double>(course_MiB_.size())) {
            course_MiB_.push_back(now_MiB);
        }
        if (passed_s() < kWarmUp_s) {
            return;
        }
        if (passed_s() < kWarmUp_s + kSpan_s) {
            warm_MiB_ = std::max(warm_MiB_, now_MiB);
        }
        if (passed_s() > seconds_ - kSpan_s) {
            last_MiB_ = std::max(last_MiB_, now_MiB);
        }
    }

    void let_heal() {
        window_.person().release(1);
        window_.person().release(2);
        window_.person().release(3);
        const double begin_s = passed_s();
        const auto state_is = [](const Report &report, servo::SafetyState state) {
            return report.column("safety_state") == static_cast<double>(state);
        };
        while (true) {
            const Report report = window_.look();
            if (state_is(report, servo::SafetyState::running)) {
                break;
            }
            ASSERT_LT(passed_s() - begin_s, kRecovered_s)
                << "the motors do not run again, round " << rounds_ << ": " << report.texts();
            if (const nlohmann::json *const go_on = report.find("condition/go on")) {
                const auto middle = [&](const char *from, const char *size) {
                    return go_on->at(from).get<float>() + 0.5F * go_on->at(size).get<float>();
                };
                window_.person().click(middle("x", "width"), middle("y", "height"));
            }
            std::this_thread::sleep_for(std::chrono::milliseconds(50));
        }
        worst_recovery_s_ = std::max(worst_recovery_s_, passed_s() - begin_s);
        ++rounds_;
    }

    double seconds_;
    std::mt19937_64 random_{kSeed};
    std::filesystem::path folder_;
    ShownWindow window_;
    Clock::time_point start_ = Clock::now();
    std::uint64_t frame_ = 0;
    int acts_ = 0;
    int rounds_ = 0;
    double worst_recovery_s_ = 0.0;
    std::vector<double> course_MiB_; ///< every `kCourse_s`
    double warm_MiB_ = 0.0;
    double last_MiB_ = 0.0;
};

TEST(KioskStorm, StaysAliveWithinItsLimitsAndHealsEachStop) {
    Storm storm(storm_seconds());
    storm.run();
    const double peak_N = storm.summed("peak force ");
    const double peak_V = storm.summed("peak voltage ");
    EXPECT_LE(peak_N, exhibit::kiosk_limits().tip_force_N);
    EXPECT_LE(peak_V, exhibit::kiosk_limits().voltage_V);
    storm.expect_healed();
    storm.expect_flat_memory();
    storm.print();
    if (!storm.has_record()) {
        return;
    }
    // What the log says of the peaks against a record of every tick.
    double recorded_N = 0.0;
    double recorded_V = 0.0;
    record::RecordReader reader(storm.record());
    while (reader.next()) {
        for (std::uint32_t row = 0; row < reader.rows(); ++row) {
            const servo::ServoSample sample = reader.read_sample(row);
            if (servo::lets_pass(sample.safety.state)) {
                recorded_N = std::max(recorded_N, sample.tip_force_N.norm());
                recorded_V = std::max(recorded_V, sample.command.e_W_V.cwiseAbs().maxCoeff());
            }
        }
    }
    constexpr double kHalfDigit = 0.005; // of the log's two
    EXPECT_GT(recorded_N, 0.1);
    EXPECT_NEAR(peak_N, recorded_N, kHalfDigit + 1e-9);
    EXPECT_NEAR(peak_V, recorded_V, kHalfDigit + 1e-9);
}

} // namespace
} // namespace springdrive::app
