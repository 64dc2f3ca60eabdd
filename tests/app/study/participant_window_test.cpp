// Covers app/study/participant/{participant_window,participant_input}.cpp and
// app/window/window.cpp: both windows on one virtual display. There is no window manager: both
// are at the top left, this one above the main one. And two monitors of different size, one of
// which goes away and comes back.
#include "app/study/participant/participant_window.h"
#include "app/window/window.h"
#include "base/input_error.h"
#include "tests/app/study/participant_pictures.h"
#include "tests/support/files.h"
#include "tests/support/pressed_keys.h"
#include "tests/support/virtual_display.h"

#include <GLFW/glfw3.h>
#include <fmt/core.h>
#include <gtest/gtest.h>
#include <imgui.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace springdrive::app::study_screen {
namespace {

class ParticipantsWindow : public ::testing::Test {
protected:
    ParticipantsWindow() {
        setenv("DISPLAY", display_.name().c_str(), 1);
        main_ = std::make_unique<Window>(
            "main", Window::Wish{.size = {640, 400}, .remembered = {}, .swaps_at_once = true});
        window_ =
            std::make_unique<ParticipantWindow>(ParticipantWindow::Wish{{}, true, {640, 360}});
        keys_ = std::make_unique<testing::PressedKeys>(display_.name());
        show(3);
        window_->take_focus();
        show(3);
        (void)window_->take_inputs();
    }

    /// Frames of both windows.
    void show(int frames) {
        for (int i = 0; i < frames; ++i) {
            main_->begin_frame();
            main_->clear();
            ImGui::Begin("panel");
            ImGui::End();
            main_->end_frame();
            window_->show(picture_);
        }
    }

    void tap(const std::vector<const char *> &keys) {
        for (const char *key : keys) {
            keys_->tap(key);
            show(2);
        }
    }

    /// Presses that were reported, by name.
    std::vector<std::string> pressed() {
        std::vector<std::string> names;
        for (const ParticipantInput &input : window_->take_inputs()) {
            if (input.is_press) {
                names.push_back(input.name);
            }
        }
        return names;
    }

    testing::VirtualDisplay display_{800, 600};
    std::unique_ptr<Window> main_;
    std::unique_ptr<ParticipantWindow> window_;
    std::unique_ptr<testing::PressedKeys> keys_;
    ParticipantPicture picture_;
};

TEST_F(ParticipantsWindow, ReportsKeysByNameAndStopsByTwoThatAreNoAnswers) {
    tap({"1", "n", "Left", "KP_Enter", "F5"});
    EXPECT_EQ(pressed(), (std::vector<std::string>{"1", "n", "left", "enter", "f5"}));
    const double before_s = steady_clock_s();
    tap({"y"});
    const std::vector<ParticipantInput> inputs = window_->take_inputs();
    ASSERT_EQ(inputs.size(), 2U); // a press and its release
    EXPECT_TRUE(inputs[0].is_press);
    EXPECT_FALSE(inputs[1].is_press);
    EXPECT_GE(inputs[0].clock_s, before_s);
    EXPECT_LE(inputs[0].clock_s, steady_clock_s());
    EXPECT_FALSE(window_->take_emergency_stop());
    for (const char *key : {"space", "F12"}) {
        tap({key});
        EXPECT_TRUE(window_->take_emergency_stop()) << key;
        EXPECT_FALSE(window_->take_emergency_stop()) << key;
    }
    EXPECT_TRUE(window_->take_inputs().empty());

    picture_.has_text_field = true; // in which F12 alone stops
    show(1);
    tap({"a", "space", "b", "c", "BackSpace"});
    EXPECT_FALSE(window_->take_emergency_stop());
    EXPECT_EQ(typed_on("", window_->take_inputs()), "a b");
    tap({"F12"});
    EXPECT_TRUE(window_->take_emergency_stop());
}

TEST_F(ParticipantsWindow, ReportsClicksOnChoicesOrMouseButtonsAsThePictureSays) {
    picture_ = picture_of_a_session("question");
    show(1);
    keys_->click(5, 5, 3);
    show(2);
    EXPECT_EQ(pressed(), std::vector<std::string>{"right"});
    picture_.choices_take_clicks = true;
    show(1);
    const Rectangle card = window_->layout().choices.at(1).card;
    keys_->click(static_cast<int>(card.corner.x + 0.5F * card.size.x),
                 static_cast<int>(card.corner.y + 0.5F * card.size.y));
    show(2);
    const std::vector<ParticipantInput> inputs = window_->take_inputs();
    ASSERT_EQ(inputs.size(), 1U);
    EXPECT_EQ(inputs[0].source, InputSource::choice);
    EXPECT_EQ(inputs[0].choice, 1U);
    EXPECT_EQ(inputs[0].name, "2");
    keys_->click(5, 5); // beside the plates
    show(2);
    EXPECT_TRUE(window_->take_inputs().empty());
}

TEST_F(ParticipantsWindow, HasNewLettersOnceItsEdgeIsNoLongerDragged) {
    picture_.heading = "1";
    show(1);
    const float before_px = window_->layout().heading.size_px;
    for (int height = 370; height <= 480; height += 10) {
        keys_->resize_window("springdrive", 640, height);
        show(1);
        EXPECT_EQ(window_->layout().heading.size_px, before_px) << height;
    }
    show(30); // half a second
    EXPECT_EQ(window_->framebuffer().height, 480);
    EXPECT_NEAR(window_->layout().heading.size_px / before_px, 480.0 / 360.0, 0.05);
}

TEST_F(ParticipantsWindow, LeavesTheMainWindowItsKeysAndContextAndFillsTheMonitorThatIsMeant) {
    GLFWwindow *const current = glfwGetCurrentContext();
    ASSERT_NE(current, nullptr);
    tap({"h"});
    EXPECT_TRUE(main_->take_keys().empty());
    window_.reset();
    EXPECT_EQ(glfwGetCurrentContext(), current);
    // Without a window manager, the focus then goes back to the pointer's window.
    keys_->click(600, 390);
    main_->begin_frame();
    ImGui::Begin("panel");
    ImGui::End();
    main_->end_frame();
    EXPECT_FALSE(main_->is_closing());

    const std::vector<MonitorFacts> there = monitors_there();
    ASSERT_EQ(there.size(), 1U);
    EXPECT_EQ(there[0].width, 800);
    EXPECT_EQ(there[0].height, 600);
    EXPECT_THROW(ParticipantWindow({"2", false, {640, 360}}), InputError);
    const ParticipantWindow full({"1", false, {640, 360}});
    EXPECT_TRUE(full.is_full_screen());
    EXPECT_EQ(full.framebuffer().width, 800);
}

std::vector<std::string> server_in(const std::filesystem::path &folder) {
    const std::filesystem::path configuration = folder / "xorg.conf";
    std::ofstream(configuration) << R"(
Section "ServerFlags"
  Option "AutoAddDevices" "false"
EndSection
Section "Device"
  Identifier "no card"
  Driver "dummy"
  VideoRam 256000
EndSection
Section "Screen"
  Identifier "all monitors"
  Device "no card"
  DefaultDepth 24
  SubSection "Display"
    Depth 24
    Modes "1024x768"
    Virtual 8192 4096
  EndSubSection
EndSection
)";
    return {"Xorg",        "-config",           configuration.string(),
            "-logfile",    folder / "xorg.log", "-noreset",
            "-novtswitch", "-sharevts"};
}

/// A virtual display with monitors that are plugged in and pulled out. Xvfb has one only; Xorg with
/// its driver "dummy" has sixteen, DUMMY0 and so on, of which the first, of 1024 × 768 pixels, is
/// there from the start.
class PluggedMonitors {
public:
    /// @param folder  for the server's files
    /// @throw std::runtime_error  there is no such server here
    explicit PluggedMonitors(const std::filesystem::path &folder) : display_(server_in(folder)) {}

    /// Of so many pixels, to the right of the first.
    /// @throw std::runtime_error  the display refuses
    void plug(int monitor, int width, int height) {
        // Blanking does not matter where nothing is scanned out: 60 frames a second.
        const std::string mode = fmt::format("test{}x{}", width, height);
        const int line = width + 160;
        const int lines = height + 30;
        static_cast<void>(std::system(
            fmt::format("export DISPLAY={}; xrandr --newmode {} {:.2f} {} {} {} {} {} {} {} {} "
                        "2>/dev/null; xrandr --addmode DUMMY{} {} 2>/dev/null",
                        display_.name(), mode, 60e-6 * line * lines, width, width + 48, width + 80,
                        line, height, height + 3, height + 8, lines, monitor, mode)
                .c_str())); // either may be there already
        set(fmt::format("--output DUMMY{} --mode {} --right-of DUMMY0", monitor, mode));
    }
    void pull(int monitor) { set(fmt::format("--output DUMMY{} --off", monitor)); }

    [[nodiscard]] const testing::VirtualDisplay &display() const { return display_; }

private:
    /// The dummy driver notices by a query only that a monitor is there: a real one, by itself.
    void set(const std::string &arguments) const {
        if (std::system(
                fmt::format("DISPLAY={0} xrandr {1} && DISPLAY={0} xrandr --query >/dev/null",
                            display_.name(), arguments)
                    .c_str()) != 0) {
            throw std::runtime_error("xrandr refuses " + arguments);
        }
    }

    testing::VirtualDisplay display_;
};

void show_for(double duration_s, Window &main, ParticipantWindow &window) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(duration_s);
    while (std::chrono::steady_clock::now() < end) {
        main.begin_frame();
        main.clear();
        main.end_frame();
        window.show({});
    }
}

TEST(TwoMonitors, AreToldApartAndFollowedWhenOneGoesAndComesBack) {
    std::optional<PluggedMonitors> monitors;
    try {
        monitors.emplace(testing::fresh_folder("two_monitors"));
    } catch (const std::runtime_error &none) {
        GTEST_SKIP() << none.what(); // Xorg may need rights that this user has not
    }
    setenv("DISPLAY", monitors->display().name().c_str(), 1);
    monitors->plug(1, 2560, 1440);
    Window main("main", Window::Wish{.size = {640, 400}, .remembered = {}, .swaps_at_once = true});
    const std::vector<MonitorFacts> there = monitors_there();
    ASSERT_EQ(there.size(), 2U);
    EXPECT_EQ(monitor_line(0, there[0]), "1: DUMMY0 1024×768");
    EXPECT_EQ(monitor_line(1, there[1]), "2: DUMMY1 2560×1440");
    ParticipantWindow window({"", false, {640, 360}}); // the second by itself
    show_for(1.0, main, window);
    EXPECT_EQ(window.monitor(), "DUMMY1");
    EXPECT_TRUE(window.is_full_screen());
    EXPECT_EQ(window.framebuffer().width, 2560);

    monitors->pull(1);
    show_for(2.0, main, window);
    EXPECT_FALSE(window.is_full_screen());
    EXPECT_EQ(monitors_there().size(), 1U);

    monitors->plug(1, 800, 600); // another one, on the same cable
    show_for(2.0, main, window);
    EXPECT_TRUE(window.is_full_screen());
    EXPECT_EQ(window.framebuffer().width, 800);
}

} // namespace
} // namespace springdrive::app::study_screen
