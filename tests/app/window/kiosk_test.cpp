// Covers app/exhibit/{kiosk,kiosk_screen,lost_display}.cpp: an exhibit as its visitors,
// its demonstrator and its computer treat it. See kiosk_storm_test.cpp for all of that at once.
#include "app/exhibit/course.h"
#include "app/exhibit/kiosk_limits.h"
#include "app/exhibit/lost_display.h"
#include "app/exhibit/trip_recovery.h"
#include "engine/control/tuning.h"
#include "engine/servo/safety_status.h"
#include "tests/support/devices.h"
#include "tests/support/files.h"
#include "tests/support/shown_window.h"

#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cmath>
#include <csignal>
#include <fstream>
#include <memory>
#include <optional>
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

// See draw_without_threads. Without it llvmpipe has a thread for each processor.
TEST_F(KioskInTheWindow, DrawsWithoutLlvmpipesThreads) {
    open();
    wait_for("Touch to begin");
    const std::vector<std::string> names = threads_of(window().program().process());
    EXPECT_GE(names.size(), 2U); // the servo has one
    for (const std::string &name : names) {
        EXPECT_FALSE(name.starts_with("llvmpipe")) << name;
    }
}

TEST_F(KioskInTheWindow, FillsTheScreenAndAttractsWithoutPanels) {
    open();
    wait_until_driven();
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
}

// Half a degree at two metres is 6.5 % of the height of the picture, see kiosk_screen.h. A
// direction takes more: a whole degree.
TEST_F(KioskInTheWindow, ShowsTheWrongDirectionByAnArrowThatIsSeenFromTwoMetres) {
    open();
    take_turn();
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
}

TEST_F(KioskInTheWindow, NoKeyNoFileAndNoTitleBarLeadsOut) {
    std::ofstream(folder() / "own.csv") << "t,x,y,z\n0,0,0.05,0\n1,0,0.05,0\n";
    open();
    wait_until_driven();
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

TEST_F(KioskInTheWindow, StopsByTheButtonUntilAPersonLetsItGoOn) {
    open();
    wait_until_driven();
    window().click("stop/stop");
    const Report stopped = window().wait_until(
        [](const Report &report) { return is_in(report, servo::SafetyState::tripped); }, "stopped");
    EXPECT_EQ(stopped.column("trip_cause"), static_cast<double>(servo::TripCause::emergency_stop));
    wait_for("Is nobody in its way?");
    touch(); // a visitor who touches anything else
    window().click("choices/next visitor");
    expect_stays_stopped(2.0 * exhibit::TripRecovery::kPause_s);
    window().click("condition/go on");
    wait_until_driven();
    window().person().key("F12");
    window().wait_until(
        [](const Report &report) { return is_in(report, servo::SafetyState::tripped); },
        "stopped by the key");
    EXPECT_EQ(window().program().end(SIGTERM).exit_status, 0);
    const std::string log_text = testing::contents_of(log());
    EXPECT_NE(log_text.find("stopped: emergency stop"), std::string::npos) << log_text;
    EXPECT_NE(log_text.find("2 stops, 1 healed"), std::string::npos) << log_text;
}

TEST_F(KioskInTheWindow, TheNextVisitorFindsAllAsItWas) {
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
    window().person().key("F12");
    window().wait_until(
        [](const Report &report) { return is_in(report, servo::SafetyState::tripped); }, "stopped");
    window().click("choices/next visitor");
    window().click("condition/go on");
    wait_for("A stiff wall");
    wait_until_driven();
    const Report next = window().wait_until(
        [](const Report &report) { return std::abs(report.column("tip_x_m")) < 0.002; },
        "the scripted hand has taken over");
    EXPECT_EQ(next.column("map"), static_cast<double>(control::MotionMap::transpose));
    EXPECT_NEAR(next.item("device and scene").at("width").get<double>(), fresh_width, kByPose);
    EXPECT_TRUE(next.shows("Watch"));
    EXPECT_EQ(window().program().end(SIGTERM).exit_status, 0);
    EXPECT_NE(testing::contents_of(log()).find("visitor 2 begins"), std::string::npos);
}

TEST_F(KioskInTheWindow, ComesBackWhenItsDeviceIsPluggedInAgainAndAPersonLetsItGoOn) {
    open({"--device", "emulated", "--fault", "unplug@4-6"});
    wait_for("The device is not connected.");
    wait_for("Is nobody in its way?");
    expect_stays_stopped(2.0 * exhibit::TripRecovery::kPause_s);
    window().click("condition/go on");
    window().wait_until(is_running, "it runs again", 30.0);
    EXPECT_EQ(window().program().end(SIGTERM).exit_status, 0);
    const std::string log_text = testing::contents_of(log());
    EXPECT_NE(log_text.find("the device is there again"), std::string::npos) << log_text;
    EXPECT_NE(log_text.find("the device was lost 1 time;"), std::string::npos) << log_text;
}

TEST_F(KioskInTheWindow, ItsBoardsStopSwitchHoldsAfterItsRelease) {
    open({"--device", "emulated", "--fault", "stop@4-8"});
    wait_until_driven();
    wait_for("Is nobody in its way?");
    window().person().key("F12"); // during the other stop
    expect_stays_stopped(4.0 + 2.0 * exhibit::TripRecovery::kPause_s);
    window().click("condition/go on");
    window().wait_until(is_running, "it runs again", 30.0);
    EXPECT_EQ(window().program().end(SIGTERM).exit_status, 0);
    const std::string log_text = testing::contents_of(log());
    EXPECT_NE(log_text.find("its stop switch"), std::string::npos) << log_text;
    EXPECT_NE(log_text.find("stopped by hand while it was stopped"), std::string::npos) << log_text;
    EXPECT_NE(log_text.find("a person lets it go on"), std::string::npos) << log_text;
}

TEST(KioskOptions, RefusesWhatIsNotForVisitorsInOneLine) {
    const std::vector<std::pair<std::vector<std::string>, std::string>> refused{
        {{"--kiosk", "--scene", "a.gltf"}, "--scene: not with --kiosk"},
        {{"--kiosk", "a.gltf"}, "file: not with --kiosk"},
        {{"--kiosk", "--open", "a.rec"}, "--open: not with --kiosk"},
        {{"--kiosk", "--at-zero"}, "--at-zero: not with --kiosk"},
        {{"--kiosk", "--assistant"}, "--assistant: not with --kiosk"},
        {{"--kiosk", "--path", "a.csv"}, "--path: not with --kiosk"},
        {{"--kiosk", "--settings", "a"}, "--settings: not with --kiosk"},
        {{"--kiosk", "--model", "auto"}, "--model auto: not with --kiosk"},
        {{"--kiosk", "--log", "/nowhere/day.log"}, "--log /nowhere/day.log: cannot be written"},
        {{"--kiosk", "--log", "/dev/full"}, "--log /dev/full: cannot be written"},
        {{"--log", "day.log"}, "add --kiosk"}};
    for (const auto &[arguments, says] : refused) {
        std::vector<std::string> words{"demo"};
        words.insert(words.end(), arguments.begin(), arguments.end());
        testing::expect_refused(testing::run_program(words), says);
    }
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
    EXPECT_EQ(ending.exit_status, exhibit::kLostDisplay);
    EXPECT_NE(ending.error.find("springdrive: the display is lost"), std::string::npos)
        << ending.error;
    EXPECT_NE(testing::contents_of(log).find("end, the display is lost: "), std::string::npos);
}

} // namespace
} // namespace springdrive::app
