// Covers app/study/participant/participant_window.cpp, participant_events.cpp and
// app/window/gl_window.cpp: both windows on one virtual display. There is no window manager: both
// are at the top left, this one above the main one.
#include "app/study/participant/monitors.h"
#include "app/study/participant/participant_window.h"
#include "app/window/window.h"
#include "base/input_error.h"
#include "tests/app/study/participant_pictures.h"
#include "tests/support/pressed_keys.h"
#include "tests/support/virtual_display.h"

#include <GLFW/glfw3.h>
#include <gtest/gtest.h>
#include <imgui.h>

#include <chrono>
#include <cstdlib>

namespace springdrive::app::study_screen {
namespace {

double now_s() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

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

TEST_F(ParticipantsWindow, ReportsKeysByNameAndTheTimeAtWhichTheyWerePolled) {
    for (const char *key : {"1", "n", "Left", "KP_Enter", "F5"}) {
        keys_->tap(key);
        show(2);
    }
    EXPECT_EQ(pressed(), (std::vector<std::string>{"1", "n", "left", "enter", "f5"}));
    const double before_s = now_s();
    keys_->tap("y");
    show(2);
    const std::vector<ParticipantInput> inputs = window_->take_inputs();
    ASSERT_EQ(inputs.size(), 2U); // a press and its release
    EXPECT_TRUE(inputs[0].is_press);
    EXPECT_FALSE(inputs[1].is_press);
    EXPECT_GE(inputs[0].clock_s, before_s);
    EXPECT_LE(inputs[0].clock_s, now_s());
    EXPECT_FALSE(window_->take_emergency_stop());
}

TEST_F(ParticipantsWindow, StopsByF12AndTheSpaceBarWhichAreNoAnswers) {
    for (const char *key : {"space", "F12"}) {
        keys_->tap(key);
        show(2);
        EXPECT_TRUE(window_->take_emergency_stop()) << key;
        EXPECT_FALSE(window_->take_emergency_stop()) << key;
    }
    EXPECT_TRUE(window_->take_inputs().empty());
}

TEST_F(ParticipantsWindow, TypesAFreeTextInWhichF12AloneStops) {
    picture_.has_text_field = true;
    show(1);
    for (const char *key : {"a", "space", "b", "c", "BackSpace"}) {
        keys_->tap(key);
        show(2);
    }
    EXPECT_FALSE(window_->take_emergency_stop());
    EXPECT_EQ(typed_on("", window_->take_inputs()), "a b");
    keys_->tap("F12");
    show(2);
    EXPECT_TRUE(window_->take_emergency_stop());
}

TEST_F(ParticipantsWindow, ReportsClicksOnChoicesOrMouseButtonsAsThePictureSays) {
    picture_ = pictures_of_a_sitting().at(1).second;
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

TEST_F(ParticipantsWindow, LeavesTheMainWindowItsOwnKeysAndContext) {
    GLFWwindow *const current = glfwGetCurrentContext();
    ASSERT_NE(current, nullptr);
    keys_->tap("h");
    show(2);
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

TEST_F(ParticipantsWindow, FillsTheMonitorThatIsMeant) {
    const std::vector<MonitorFacts> there = monitors_there();
    ASSERT_EQ(there.size(), 1U);
    EXPECT_EQ(there[0].width, 800);
    EXPECT_EQ(there[0].height, 600);
    window_.reset();
    EXPECT_THROW(ParticipantWindow({"2", false, {640, 360}}), InputError);
    const ParticipantWindow full({"1", false, {640, 360}});
    EXPECT_TRUE(full.is_full_screen());
    EXPECT_EQ(full.framebuffer().width, 800);
}

} // namespace
} // namespace springdrive::app::study_screen
