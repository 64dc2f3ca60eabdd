// Covers the monitors of app/study/participant/participant_window.cpp: two of different size, one
// of which goes away and comes back.
#include "app/study/participant/participant_window.h"
#include "tests/support/files.h"
#include "tests/support/plugged_monitors.h"

#include <gtest/gtest.h>
#include <imgui.h>

#include <chrono>
#include <cstdlib>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace springdrive::app::study_screen {
namespace {

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
    std::optional<testing::PluggedMonitors> monitors;
    try {
        monitors.emplace(testing::fresh_folder("two_monitors"));
    } catch (const std::runtime_error &none) {
        GTEST_SKIP() << none.what(); // Xorg may need rights that this user has not
    }
    setenv("DISPLAY", monitors->display().name().c_str(), 1);
    monitors->plug(1, 2560, 1440);
    Window main("main", Window::Wish{{640, 400}, {}, 0.0, 1.0, false});
    EXPECT_EQ(ParticipantWindow::monitors(),
              (std::vector<std::string>{"1: DUMMY0 1024×768", "2: DUMMY1 2560×1440"}));
    ParticipantView view(0);
    ParticipantWindow window(main, {"", false, {640, 360}}); // the second by itself
    show_for(1.0, main, view, window);
    EXPECT_EQ(window.monitor(), "DUMMY1");
    EXPECT_TRUE(window.is_full_screen());
    EXPECT_EQ(window.framebuffer().width, 2560);

    monitors->pull(1);
    show_for(2.0, main, view, window);
    EXPECT_TRUE(window.has_lost_monitor());
    EXPECT_EQ(ParticipantWindow::monitors().size(), 1U);

    monitors->plug(1, 800, 600); // another one, on the same cable
    show_for(2.0, main, view, window);
    EXPECT_FALSE(window.has_lost_monitor());
    EXPECT_TRUE(window.is_full_screen());
    EXPECT_EQ(window.framebuffer().width, 800);
}

} // namespace
} // namespace springdrive::app::study_screen
