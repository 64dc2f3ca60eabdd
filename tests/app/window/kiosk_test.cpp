// Covers app/exhibit/{kiosk,kiosk_screen}.cpp and app/demo/demo.cpp: an exhibit as its visitors,
// its demonstrator and its computer treat it, and the tour of the ordinary window. See
// kiosk_storm_test.cpp for all of that at once. And app/visitors/visits.cpp with
// app/commands/study/study_try.cpp: "Can you feel it?", with a visitor at mouse and keyboard.
#include "app/demo/demo.h"
#include "app/exhibit/course.h"
#include "app/exhibit/trip_recovery.h"
#include "app/stage/frame_loop.h"
#include "engine/control/tuning.h"
#include "engine/servo/safety_status.h"
#include "tests/support/devices.h"
#include "tests/support/files.h"
#include "tests/support/shown_window.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <memory>
#include <regex>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace springdrive::app {
namespace {

namespace fs = std::filesystem;

using testing::Report;
using testing::ShownWindow;

constexpr testing::WindowSize kExhibit{1366, 768, 1.0, false}; // unlike a window's own size

bool is_in(const Report &report, servo::SafetyState state) {
    return report.column("safety_state") == static_cast<double>(state);
}

bool is_running(const Report &report) { return is_in(report, servo::SafetyState::running); }

double width_of(const Report &report) { return report.all().at("window").at("width"); }

/// An exhibit in a folder of its own, with its log in there.
class KioskInTheWindow : public ::testing::Test {
protected:
    explicit KioskInTheWindow() : folder_(testing::fresh_folder("kiosk")) {}

    void open(std::vector<std::string> more = {}) {
        more.insert(more.begin(), {"--kiosk", "--log", log()});
        window_ = std::make_unique<ShownWindow>(std::move(more), kExhibit, folder_);
    }
    [[nodiscard]] fs::path log() const { return folder_ / "day.log"; }
    [[nodiscard]] const fs::path &folder() const { return folder_; }
    ShownWindow &window() { return *window_; }
    void touch() { window().person().click(600.0F, 300.0F); }
    Report wait_for(const std::string &text, double limit_s = 20.0) {
        return window().wait_until([&](const Report &report) { return report.shows(text); },
                                   "it says \"" + text + "\"", limit_s);
    }
    void wait_until_driven(double limit_s = 20.0) {
        window().wait_until(is_running, "the motors run", limit_s);
    }
    Report wait_until_stopped() {
        return window().wait_until(
            [](const Report &report) { return is_in(report, servo::SafetyState::tripped); },
            "stopped");
    }
    void expect_stays_stopped(double seconds) {
        constexpr double kBetween_s = 0.2;
        for (double passed_s = 0.0; passed_s < seconds; passed_s += kBetween_s) {
            ASSERT_TRUE(is_in(window().look(), servo::SafetyState::tripped));
            window().let_pass(kBetween_s);
        }
    }
    void take_turn() {
        touch();
        wait_for("Watch");
        window().click("choices/my turn");
        wait_for("Your turn");
    }

private:
    fs::path folder_;
    std::unique_ptr<ShownWindow> window_;
};

void expect_only_the_exhibit(const Report &report) {
    for (const nlohmann::json &item : report.all().at("items")) {
        const std::string id = item.at("id");
        const std::string first = id.substr(0, id.find('/'));
        const bool is_known = first == "lesson" || first == "stop" || first == "stage" ||
                              first == "choices" || first == "read-outs" || first == "condition" ||
                              first == "device and scene" || first == "marks" ||
                              item.at("kind") == "text"; // captions on the scene
        EXPECT_TRUE(is_known) << id;
    }
    EXPECT_EQ(report.find("window/menu"), nullptr);
    EXPECT_EQ(report.find("Tuning"), nullptr);
}

/// Names of the process's threads.
std::vector<std::string> threads_of(pid_t process) {
    std::vector<std::string> names;
    for (const fs::directory_entry &task :
         fs::directory_iterator("/proc/" + std::to_string(process) + "/task")) {
        names.push_back(testing::contents_of(task.path() / "comm"));
    }
    return names;
}

TEST_F(KioskInTheWindow, FillsTheScreenWithoutPanelsAndNoKeyNoFileAndNoTitleBarLeadsOut) {
    std::ofstream(folder() / "own.csv") << "t,x,y,z\n0,0,0.05,0\n1,0,0.05,0\n";
    open();
    wait_until_driven();
    // See draw_without_threads. Without it llvmpipe has a thread for each processor.
    const std::vector<std::string> names = threads_of(window().program().process());
    EXPECT_GE(names.size(), 2U); // the servo has one
    for (const std::string &name : names) {
        EXPECT_FALSE(name.starts_with("llvmpipe")) << name;
    }
    const Report report = window().look();
    EXPECT_EQ(width_of(report), kExhibit.width);
    EXPECT_EQ(report.all().at("window").at("height"), kExhibit.height);
    expect_only_the_exhibit(report);
    EXPECT_TRUE(report.shows("Touch to begin"));
    EXPECT_TRUE(report.shows("A stiff wall"));
    // The scripted hand shows it: force and angle stand at the arrow, at 6.5 % of the height.
    const Report shown = window().wait_until(
        [](const Report &now) { return now.find("read-outs/angle") != nullptr; }, "it touches");
    constexpr double kDigitPerLine = 0.626; // DejaVu Sans: of digits to the height of a line
    for (const char *const id : {"read-outs/force", "read-outs/angle"}) {
        EXPECT_GT(kDigitPerLine * shown.item(id).at("height").get<double>(),
                  0.065 * kExhibit.height)
            << id;
    }
    EXPECT_EQ(shown.column("limit_tip_force_N"), exhibit::kiosk_limits().tip_force_N);
    EXPECT_EQ(shown.column("limit_voltage_V"), exhibit::kiosk_limits().voltage_V);
    take_turn();
    const Report before = window().look();
    for (const char *const key :
         {"F1",         "F6",     "F9",     "F10",    "F11",      "p",      "period", "b",
          "h",          "r",      "Escape", "Tab",    "Return",   "ctrl+s", "ctrl+z", "ctrl+y",
          "ctrl+equal", "ctrl+q", "alt+F4", "ctrl+c", "ctrl+Tab", "w",      "t"}) {
        window().person().key(key);
    }
    window().person().drop_files(600.0F, 300.0F, {testing::assets() / "scenes/slope.gltf"});
    window().person().drop_files(600.0F, 300.0F, {folder() / "own.csv"});
    window().person().close_window();
    const Report after = window().look();
    expect_only_the_exhibit(after);
    EXPECT_TRUE(after.shows("A stiff wall"));
    EXPECT_EQ(width_of(after), kExhibit.width);
    for (const char *const column : {"K_P_V_per_rad", "K_D_Vs_per_rad", "dR_Ohm", "map", "scene_id",
                                     "limit_tip_force_N", "safety_state"}) {
        EXPECT_EQ(after.column(column), before.column(column)) << column;
    }
    EXPECT_GT(after.column("time_s"), before.column("time_s")); // it is not paused
    EXPECT_TRUE(window().program().is_running());
    std::size_t files = 0;
    for (const auto &entry : fs::directory_iterator(folder())) {
        files += entry.path() != log() && entry.path().filename() != "own.csv" ? 1U : 0U;
    }
    EXPECT_EQ(files, 0U); // no session kept, no picture
    // The way out that is documented.
    window().person().key("ctrl+alt+q");
    EXPECT_EQ(window().program().end(0).exit_status, 0);
    EXPECT_NE(testing::contents_of(log()).find("end, by Ctrl+Alt+Q: 1 visitor,"),
              std::string::npos);
}

/// Half a degree at two metres is 6.5 % of the height of the picture, see kiosk.h. A
/// direction takes more: a whole degree.
TEST_F(KioskInTheWindow, StopsAndTheNextFindsAllAsItWasWithAnArrowThatIsSeenFromTwoMetres) {
    open();
    wait_until_driven();
    take_turn();
    const Report fresh = window().look();
    EXPECT_EQ(fresh.column("map"), static_cast<double>(control::MotionMap::transpose));
    const double fresh_width = fresh.item("device and scene").at("width");
    window().click("choices/next scene");
    wait_for("The wrong direction");
    window().click("choices/my turn");
    wait_for("Your turn");
    window().click("choices/other map");
    window().person().drag({500.0F, 300.0F}, {620.0F, 360.0F}, 0.3, 3); // the view
    window().person().wheel(600.0F, 300.0F, 5);
    window().person().drag({500.0F, 300.0F}, {650.0F, 250.0F}, 0.3); // the hand
    const Report used = window().look();
    EXPECT_EQ(used.column("map"), static_cast<double>(control::MotionMap::inverse));
    constexpr double kByPose = 50.0; // pixels, by the linkage's pose alone
    EXPECT_GT(std::abs(used.item("device and scene").at("width").get<double>() - fresh_width),
              2.0 * kByPose);
    EXPECT_GT(std::abs(used.column("tip_x_m")), 0.005);
    // A stop by the button holds until a person lets it go on, who is no visitor.
    window().click("stop/stop");
    const Report stopped = wait_until_stopped();
    EXPECT_EQ(stopped.column("trip_cause"), static_cast<double>(servo::TripCause::emergency_stop));
    wait_for("Is nobody in its way?");
    touch(); // a visitor who touches anything else
    window().click("choices/next visitor");
    expect_stays_stopped(2.0 * exhibit::TripRecovery::kPause_s);
    window().click("condition/go on");
    wait_for("A stiff wall");
    wait_until_driven();
    const Report next = window().wait_until(
        [](const Report &report) { return std::abs(report.column("tip_x_m")) < 0.002; },
        "the scripted hand has taken over");
    EXPECT_EQ(next.column("map"), static_cast<double>(control::MotionMap::transpose));
    EXPECT_NEAR(next.item("device and scene").at("width").get<double>(), fresh_width, kByPose);
    EXPECT_TRUE(next.shows("Watch"));
    window().click("choices/next scene");
    wait_for("The wrong direction");
    const auto force_N = [](const Report &report) {
        const nlohmann::json *const item = report.find("read-outs/force");
        return item != nullptr ? std::stod(item->at("text").get<std::string>()) : 0.0;
    };
    // The scripted hand presses with some 1.5 N.
    const Report shown = window().wait_until(
        [&](const Report &now) { return force_N(now) > 1.3 && now.find("marks/arrow") != nullptr; },
        "it presses", 40.0);
    const nlohmann::json &arrow = shown.item("marks/arrow");
    const double length =
        std::hypot(arrow.at("width").get<double>(), arrow.at("height").get<double>());
    EXPECT_GT(length, 2.0 * 0.065 * kExhibit.height) << "at " << force_N(shown) << " N";
    window().person().key("F12");
    wait_until_stopped();
    EXPECT_EQ(window().program().end(SIGTERM).exit_status, 0);
    const std::string log_text = testing::contents_of(log());
    EXPECT_NE(log_text.find("visitor 2 begins"), std::string::npos) << log_text;
    EXPECT_NE(log_text.find("stopped: emergency stop"), std::string::npos) << log_text;
    EXPECT_NE(log_text.find("2 stops, 1 healed"), std::string::npos) << log_text;
}

TEST_F(KioskInTheWindow, ComesBackWhenItsDeviceIsPluggedInAgainAndAPersonLetsItGoOn) {
    open({"--device", "emulated", "--fault", "unplug@4-6"});
    wait_for("The device is not connected.");
    wait_for("Is nobody in its way?");
    window().person().key("F12"); // during the other stop
    expect_stays_stopped(2.0 * exhibit::TripRecovery::kPause_s);
    window().click("condition/go on");
    window().wait_until(is_running, "it runs again", 30.0);
    EXPECT_EQ(window().program().end(SIGTERM).exit_status, 0);
    const std::string log_text = testing::contents_of(log());
    EXPECT_NE(log_text.find("the device is there again"), std::string::npos) << log_text;
    EXPECT_NE(log_text.find("stopped by hand while it was stopped"), std::string::npos) << log_text;
    EXPECT_NE(log_text.find("a person lets it go on"), std::string::npos) << log_text;
    EXPECT_NE(log_text.find("the device was lost 1 time;"), std::string::npos) << log_text;
}

/// As its service expects, which then starts it again.
TEST(KioskDisplay, AHangEndsTheProgramByItsAlarm) {
    const fs::path log = testing::fresh_folder("kiosk_hanging") / "day.log";
    ShownWindow window({"--kiosk", "--log", log}, kExhibit, {}, testing::Pace::clock);
    EXPECT_TRUE(window.look().shows("Touch to begin"));
    window.display().freeze(); // whatever is drawn now waits for it
    const auto begin = std::chrono::steady_clock::now();
    while (window.program().is_running() &&
           std::chrono::steady_clock::now() - begin < std::chrono::seconds(50)) {
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    EXPECT_FALSE(window.program().is_running());
    window.display().go_on();
    EXPECT_EQ(window.program().end(0).exit_status, -1) << "by a signal";
}

TEST(KioskDisplay, ALostOneEndsTheProgramInOneLineAndInTheLog) {
    const fs::path log = testing::fresh_folder("kiosk_display") / "day.log";
    auto display = std::make_unique<testing::VirtualDisplay>(1280, 720);
    testing::RunningProgram program(*display, {"demo", "--report", "--kiosk", "--log", log});
    program.send_line("report");
    ASSERT_TRUE(program.read_line(std::chrono::seconds(60)));
    display.reset();
    const testing::Ending ending = program.end(0);
    EXPECT_EQ(ending.exit_status, kLostDisplay);
    EXPECT_NE(ending.error.find("springdrive: the display is lost"), std::string::npos)
        << ending.error;
    EXPECT_NE(testing::contents_of(log).find("end, the display is lost: "), std::string::npos);
}

TEST(TourInTheWindow, TouchesTheFirstSceneAndEndsWithEscape) {
    ShownWindow window;
    window.wait_until_running();
    const double K_P = window.look().column("K_P_V_per_rad");
    window.click("window/menu");
    window.click("tour of the scenes");
    window.wait_until([](const Report &report) { return report.shows("A stiff wall"); },
                      "the first scene");
    window.wait_until([](const Report &report) { return report.column("touching") != 0.0; },
                      "the scripted hand touches it");
    EXPECT_TRUE(window.look().shows("the hand follows a path"));
    window.person().key("Escape");
    window.wait_until([](const Report &report) { return report.shows("left press on the scene"); },
                      "the hand is its user's");
    const Report after = window.look();
    EXPECT_EQ(after.column("K_P_V_per_rad"), K_P);
    EXPECT_EQ(after.column("safety_state"), static_cast<double>(servo::SafetyState::running));
    EXPECT_NE(after.find("Tuning"), nullptr);
}

/// The shipped protocol with two trials and no practice.
fs::path short_protocol(const fs::path &folder) {
    std::string text =
        testing::contents_of(testing::assets() / "protocols" / "can_you_feel_it.toml");
    for (const auto &[pattern, replacement] : {std::pair{"\nfewest_trials = 34\nmost_trials = 34",
                                                         "\nfewest_trials = 2\nmost_trials = 2"},
                                               std::pair{"\nfewest_trials = 3\nmost_trials = 3",
                                                         "\nfewest_trials = 0\nmost_trials = 0"}}) {
        EXPECT_NE(text.find(pattern), std::string::npos);
        text = std::regex_replace(text, std::regex(pattern), replacement);
    }
    const fs::path file = folder / "short.toml";
    std::ofstream(file) << text;
    return file;
}

/// Files that this test has open, from whoever started it (CTest, say): a program inherits them.
std::set<fs::path> inherited_files() {
    std::set<fs::path> files;
    for (const fs::directory_entry &entry : fs::directory_iterator("/proc/self/fd")) {
        std::error_code gone;
        files.insert(fs::read_symlink(entry.path(), gone));
    }
    return files;
}

/// Regular files that a process has open for writing, apart from its standard error and from what
/// it inherited.
std::vector<std::string> written_files(pid_t process) {
    const fs::path proc = "/proc/" + std::to_string(process);
    const fs::path error = fs::read_symlink(proc / "fd/2");
    const std::set<fs::path> inherited = inherited_files();
    std::vector<std::string> files;
    for (const fs::directory_entry &entry : fs::directory_iterator(proc / "fd")) {
        std::error_code gone;
        const fs::path target = fs::read_symlink(entry.path(), gone);
        const std::string number = entry.path().filename();
        if (gone || target == error || inherited.contains(target) ||
            !fs::is_regular_file(target, gone)) {
            continue;
        }
        const std::string info = testing::contents_of(proc / "fdinfo" / number);
        const std::size_t flags = info.find("flags:");
        const unsigned long mode = std::stoul(info.substr(flags + 6), nullptr, 8);
        if ((mode & 3UL) != 0) { // not O_RDONLY
            files.push_back(target);
        }
    }
    return files;
}

std::vector<fs::path> names_in(const fs::path &folder) {
    std::vector<fs::path> names;
    for (const fs::directory_entry &entry : fs::recursive_directory_iterator(folder)) {
        names.push_back(entry.path());
    }
    std::ranges::sort(names);
    return names;
}

class VisitorsInTheWindow : public ::testing::Test {
protected:
    VisitorsInTheWindow()
        : folder_(testing::fresh_folder("visitors")), protocol_(short_protocol(folder_)),
          display_(1280, 720),
          program_(display_, {"study", "try", protocol_.string(), "--report"}, folder_),
          person_(display_) {
        wait_for("Can you feel it?"); // by then there is one window only
        person_.wait_for_window();
    }

    Report look() {
        program_.send_line("report");
        const auto line = program_.read_line(std::chrono::seconds(60));
        if (!line) {
            throw std::runtime_error("the window does not report: " + program_.error());
        }
        return Report(nlohmann::json::parse(*line));
    }

    Report wait_for(const std::string &text, double limit_s = 40.0) {
        const auto start = std::chrono::steady_clock::now();
        for (;;) {
            Report report = look();
            if (report.shows(text)) {
                return report;
            }
            if (std::chrono::steady_clock::now() - start > std::chrono::duration<double>(limit_s)) {
                ADD_FAILURE() << "not shown: " << text << "; but\n" << report.texts();
                return report;
            }
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
        }
    }

    void click_choice(int number) {
        const Report report = look();
        const nlohmann::json &item = report.item("visitor/choice " + std::to_string(number));
        person_.click(item.at("x").get<float>() + 0.5F * item.at("width").get<float>(),
                      item.at("y").get<float>() + 0.5F * item.at("height").get<float>());
    }

    fs::path folder_;
    fs::path protocol_;
    testing::VirtualDisplay display_;
    testing::RunningProgram program_;
    testing::Person person_;
};

TEST_F(VisitorsInTheWindow, FromTheStartToTheCurveAndToTheNextOneWithoutAFile) {
    const std::vector<fs::path> before = names_in(folder_);
    const Report start = wait_for("Can you feel it?");
    EXPECT_EQ(start.all().at("window").at("width"), 1280.0); // it fills the screen
    EXPECT_EQ(start.all().at("window").at("height"), 720.0);
    EXPECT_TRUE(start.shows("Nothing of this is kept"));
    EXPECT_TRUE(start.shows("there is nothing to feel"));
    click_choice(2); // "Guess"
    wait_for("Hold the pen");
    click_choice(1); // "Go on"
    for (int trial = 0; trial < 2; ++trial) {
        wait_for("Press 1 or 2.");
        EXPECT_EQ(written_files(program_.process()), std::vector<std::string>{});
        if (trial == 0) {
            click_choice(1);
            wait_for("Hold still"); // above the mark: the next one
        } else {
            person_.key("2");
        }
    }
    const Report curve = wait_for("These were guesses");
    EXPECT_FALSE(curve.item("visitor/curve").at("text").get<std::string>().empty());
    EXPECT_EQ(written_files(program_.process()), std::vector<std::string>{});
    EXPECT_EQ(names_in(folder_), before);
    person_.key("Return");
    wait_for("Can you feel it?");
    person_.key("ctrl+alt+q");
    const testing::Ending ending = program_.end(0);
    EXPECT_EQ(ending.exit_status, 0) << ending.error;
    EXPECT_NE(ending.error.find("1 visit begun; nothing of them was stored"), std::string::npos)
        << ending.error;
    EXPECT_EQ(names_in(folder_), before);
}

} // namespace
} // namespace springdrive::app
