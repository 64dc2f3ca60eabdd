// Covers the monitors of app/study/participant/participant_window.cpp: two of different size, one
// of which goes away and comes back.
#include "app/study/participant/monitors.h"
#include "app/study/participant/participant_window.h"
#include "app/window/window.h"
#include "tests/support/files.h"
#include "tests/support/virtual_display.h"

#include <gtest/gtest.h>
#include <imgui.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fmt/core.h>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace springdrive::app::study_screen {
namespace {

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
/// its driver "dummy" has sixteen, DUMMY0 and so on, of which the first is there from the start.
class PluggedMonitors {
public:
    /// The first monitor has 1024 × 768 pixels.
    /// @param folder  for the server's files
    /// @throw std::runtime_error  there is no such server here
    explicit PluggedMonitors(const std::filesystem::path &folder);

    /// Of so many pixels, to the right of the first.
    /// @throw std::runtime_error  the display refuses
    void plug(int monitor, int width, int height);
    void pull(int monitor);

    [[nodiscard]] const testing::VirtualDisplay &display() const { return display_; }

private:
    void set(const std::string &arguments) const;

    testing::VirtualDisplay display_;
};

PluggedMonitors::PluggedMonitors(const std::filesystem::path &folder)
    : display_(server_in(folder)) {}

void PluggedMonitors::plug(int monitor, int width, int height) {
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

void PluggedMonitors::pull(int monitor) { set(fmt::format("--output DUMMY{} --off", monitor)); }

/// The dummy driver notices by a query only that a monitor is there: a real one, by itself.
void PluggedMonitors::set(const std::string &arguments) const {
    if (std::system(fmt::format("DISPLAY={0} xrandr {1} && DISPLAY={0} xrandr --query >/dev/null",
                                display_.name(), arguments)
                        .c_str()) != 0) {
        throw std::runtime_error("xrandr refuses " + arguments);
    }
}

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
