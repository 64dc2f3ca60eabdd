// Covers the monitors of app/study/participant/participant_window.cpp: two of them, one of which
// goes away and comes back. Xvfb has only one; Xorg with its driver "dummy" has sixteen that can be
// plugged in (packages xserver-xorg-video-dummy and x11-xserver-utils). Run by hand, skipped
// otherwise:
//
//   Xorg -noreset -novtswitch -sharevts -config CONFIG :87 &     a Device with Driver "dummy"
//   SPRINGDRIVE_TWO_MONITORS=:87 participant_tests --gtest_filter='TwoMonitors.*'
#include "app/study/participant/participant_window.h"

#include <gtest/gtest.h>
#include <imgui.h>

#include <chrono>
#include <cstdlib>

namespace springdrive::app::study_screen {
namespace {

void set_monitors(const std::string &arguments) {
    ASSERT_EQ(std::system(("xrandr " + arguments).c_str()), 0);
}

void show_for(double duration_s, Window &main, ParticipantView &view, ParticipantWindow &window) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(duration_s);
    while (std::chrono::steady_clock::now() < end) {
        main.begin_frame();
        main.clear();
        main.end_frame();
        window.show(view, {});
    }
}

TEST(TwoMonitors, AreToldApartAndFollowedWhenOneGoesAndComesBack) {
    const char *const display = std::getenv("SPRINGDRIVE_TWO_MONITORS");
    if (display == nullptr) {
        GTEST_SKIP() << "no display with two monitors";
    }
    setenv("DISPLAY", display, 1);
    const std::string plugged = "--output DUMMY1 --mode 800x600 --right-of DUMMY0";
    (void)std::system("xrandr --addmode DUMMY1 800x600"); // fails where it has it already
    set_monitors(plugged);
    Window main("main", Window::Wish{{640, 400}, {}, 0.0, 1.0, false});
    EXPECT_EQ(ParticipantWindow::monitors(),
              (std::vector<std::string>{"1: DUMMY0 1024×768", "2: DUMMY1 800×600"}));
    ParticipantView view(0);
    ParticipantWindow window(main, {"", false, {640, 360}}); // the second by itself
    show_for(1.0, main, view, window);
    EXPECT_EQ(window.monitor(), "DUMMY1");
    EXPECT_TRUE(window.is_full_screen());
    EXPECT_EQ(window.framebuffer().width, 800);

    set_monitors("--output DUMMY1 --off");
    show_for(2.0, main, view, window);
    EXPECT_TRUE(window.has_lost_monitor());
    EXPECT_EQ(ParticipantWindow::monitors().size(), 1U);

    set_monitors(plugged);
    show_for(2.0, main, view, window);
    EXPECT_FALSE(window.has_lost_monitor());
    EXPECT_TRUE(window.is_full_screen());
    EXPECT_EQ(window.framebuffer().width, 800);
}

} // namespace
} // namespace springdrive::app::study_screen
