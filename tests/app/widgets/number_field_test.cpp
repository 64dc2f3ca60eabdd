// Covers app/widgets/number_field.cpp and InputQueue: numbers as they are typed.
#include "app/widgets/widgets.h"
#include "app/window/window.h"
#include "tests/support/imgui_frame.h"

#include <GLFW/glfw3.h>
#include <gtest/gtest.h>

#include <functional>
#include <random>
#include <string>
#include <vector>

namespace springdrive::app {
namespace {

constexpr float kFramePeriod_s = 0.1F; // ten frames a second

class NumberField : public testing::ImGuiFrame {
protected:
    NumberField() {
        ImGuiIO &io = ImGui::GetIO(); // as its backend does
        io.DeltaTime = kFramePeriod_s;
        io.KeyMap[ImGuiKey_Enter] = GLFW_KEY_ENTER;
        io.KeyMap[ImGuiKey_Escape] = GLFW_KEY_ESCAPE;
        io.KeyMap[ImGuiKey_Backspace] = GLFW_KEY_BACKSPACE;
        io.KeyMap[ImGuiKey_LeftArrow] = GLFW_KEY_LEFT;
        io.KeyMap[ImGuiKey_A] = GLFW_KEY_A;
        frame();
        frame(); // ImGui hides a window in its first one
    }
    ~NumberField() override { ui::report().begin(false); }

    void frame() {
        ImGui::EndFrame();
        static_cast<void>(queue.feed(ImGui::GetIO()));
        ImGui::NewFrame();
        ui::report().begin(true);
        ImGui::SetNextWindowPos({10.0F, 10.0F});
        ImGui::SetNextWindowSize({600.0F, 300.0F});
        ImGui::Begin("window");
        times_set += ui::number_field("##field", value, "%.3f", {"K_P", 0.0, 500.0, "V/rad"});
        field = ImGui::GetItemRectMin();
        times_set += ui::slider_with_number("##slider", share, 0.0, 8.5, "delay %.2f periods");
        slider = ImGui::GetItemRectMin();
        ImGui::End();
    }
    void run() {
        do {
            frame();
        } while (queue.is_waiting());
        frame();
    }

    void click(ImVec2 corner) {
        const ImVec2 place{corner.x + 8.0F, corner.y + 8.0F};
        queue.button(0, true, place);
        queue.button(0, false, place);
    }
    void key(int code) {
        queue.press({code, 0, 0, false});
        queue.release(code);
    }
    /// The keys of which a letter comes are no business of ImGui's.
    void type(const std::string &text) {
        for (const char letter : text) {
            queue.press({letter, 0, 0, false});
            queue.letter(static_cast<unsigned>(letter));
            queue.release(letter);
        }
    }
    void select_all() {
        queue.press({GLFW_KEY_LEFT_CONTROL, 0, 0, false});
        key(GLFW_KEY_A);
        queue.release(GLFW_KEY_LEFT_CONTROL);
    }
    void enter(const std::string &text) {
        click(field);
        select_all();
        type(text);
        key(GLFW_KEY_ENTER);
        run();
    }
    static std::string shown(const std::string &kind) {
        for (const ShownItem &item : ui::report().items()) {
            if (item.kind == kind) {
                return item.text;
            }
        }
        return {};
    }

    InputQueue queue;
    double value = 6.0;
    double share = 1.0;
    int times_set = 0;
    ImVec2 field;
    ImVec2 slider;
};

TEST_F(NumberField, ACommaIsADecimalPoint) {
    for (const auto &[text, number] : std::vector<std::pair<std::string, double>>{{"6,5", 6.5},
                                                                                  {"0,01", 0.01},
                                                                                  {"7.25", 7.25},
                                                                                  {",5", 0.5},
                                                                                  {"1e2", 100.0},
                                                                                  {"3,5e1", 35.0},
                                                                                  {" 12 ", 12.0},
                                                                                  {"500", 500.0},
                                                                                  {"0", 0.0}}) {
        times_set = 0;
        enter(text);
        EXPECT_EQ(value, number) << text;
        EXPECT_EQ(times_set, 1) << text;
        EXPECT_EQ(shown("error"), "") << text;
    }
}

TEST_F(NumberField, WhatIsNoNumberAsAWholeIsRefusedAndSaidSo) {
    for (const char *text : {"6x5", "6.5.1", "6,5,1", "1,000.5", "1e", "65q", "nan", "inf", "0x10",
                             "--5", "6 5", "6;5", "x", "1e999"}) {
        enter(text);
        EXPECT_EQ(value, 6.0) << text;
        EXPECT_EQ(shown("error"),
                  "K_P '" + std::string(text) + "' is no number from 0 to 500 V/rad: not set");
        EXPECT_EQ(shown("number"), "6.000") << text;
    }
    EXPECT_EQ(times_set, 0);
    enter("7");
    EXPECT_EQ(value, 7.0);
    EXPECT_EQ(shown("error"), "");
}

TEST_F(NumberField, WhatIsOutOfRangeIsRefusedOnBothSides) {
    for (const char *text : {"500,01", "-0,01", "1e300"}) {
        enter(text);
        EXPECT_EQ(value, 6.0) << text;
        EXPECT_NE(shown("error").find("is out of range, 0 to 500 V/rad: not set"),
                  std::string::npos);
    }
    click(slider); // takes the words away
    run();
    EXPECT_EQ(shown("error"), "");
}

TEST_F(NumberField, EveryKeyShows) {
    click(field);
    select_all();
    std::string typed;
    for (char letter = '!'; letter <= '~'; ++letter) {
        type(std::string(1, letter));
        typed += letter;
        run();
        EXPECT_EQ(shown("number"), typed);
    }
}

TEST_F(NumberField, EscapeAnEmptyFieldAndALookLeaveTheValue) {
    value = 6.00049; // of which the field shows less
    for (const auto &leave : std::vector<std::function<void()>>{
             [&] { type("9"), key(GLFW_KEY_ESCAPE); },
             [&] { select_all(), key(GLFW_KEY_BACKSPACE), key(GLFW_KEY_ENTER); },
             [&] { key(GLFW_KEY_ENTER); }}) {
        click(field);
        leave();
        run();
        EXPECT_EQ(value, 6.00049);
        EXPECT_EQ(shown("error"), "");
    }
}

TEST_F(NumberField, ANumberIsCompleteWhenAClickElsewhereLeavesTheField) {
    click(field);
    select_all();
    type("8,5");
    click(slider);
    run();
    EXPECT_EQ(value, 8.5);
}

TEST_F(NumberField, ASliderTakesNumbersInTheSameWay) {
    const auto enter_on_slider = [&](const std::string &text) {
        queue.press({GLFW_KEY_LEFT_CONTROL, 0, 0, false});
        click(slider);
        queue.release(GLFW_KEY_LEFT_CONTROL);
        type(text);
        key(GLFW_KEY_ENTER);
        run();
    };
    enter_on_slider("6,5");
    EXPECT_EQ(share, 6.5);
    enter_on_slider("6x5");
    EXPECT_EQ(share, 6.5);
    EXPECT_EQ(shown("error"), "'6x5' is no number from 0 to 8.5: not set");
    enter_on_slider("8,6");
    EXPECT_EQ(share, 6.5);
    EXPECT_EQ(shown("error"), "8.6 is out of range, 0 to 8.5: not set");
    share = 1.23456;
    enter_on_slider("");
    EXPECT_EQ(share, 1.23456); // not what is shown of it
}

/// However many events fall into a frame, what comes of them is as if each had had its own.
TEST_F(NumberField, WhatIsTypedDoesNotDependOnFrames) {
    enter("1234567890123456"); // in a tenth of a second
    EXPECT_EQ(times_set, 0);
    EXPECT_EQ(shown("error"), "K_P 1.23457e+15 is out of range, 0 to 500 V/rad: not set");
    enter("12,3456789012345");
    EXPECT_EQ(value, 12.3456789012345);

    std::mt19937 random(7);
    for (int trial = 0; trial < 200; ++trial) {
        std::string text = "0,";
        const auto begin = [&] {
            select_all();
            type("0,");
            text = "0,";
        };
        click(field);
        begin();
        for (int i = 0; i < 12; ++i) {
            const auto what = random() % 6;
            if (what == 0 && text.size() > 2) {
                key(GLFW_KEY_BACKSPACE);
                text.pop_back();
            } else if (what == 1) {
                begin();
            } else {
                text += static_cast<char>('1' + random() % 9);
                type(text.substr(text.size() - 1));
            }
            if (random() % 5 == 0) {
                frame();
            }
        }
        key(GLFW_KEY_ENTER);
        run();
        text[1] = '.';
        ASSERT_EQ(value, std::stod(text)) << "trial " << trial;
    }
}

/// A long word does not hold up what comes after it.
TEST_F(NumberField, ALetterThatIsTypedAgainAndAgainTakesNoFrameEach) {
    click(field);
    run();
    type(std::string(300, '1'));
    frame();
    EXPECT_FALSE(queue.is_waiting());
}

TEST(InputQueue, KeysThatGoDownAreToldInOrderEvenIfTheyAreShort) {
    ImGui::CreateContext();
    {
        ImGuiIO &io = ImGui::GetIO();
        InputQueue queue;
        queue.press({GLFW_KEY_M, 58, 0, false});
        queue.release(GLFW_KEY_M);
        queue.press({GLFW_KEY_M, 58, 0, false});
        queue.release(GLFW_KEY_M);
        std::vector<KeyDown> pressed = queue.feed(io);
        ASSERT_EQ(pressed.size(), 1U);
        EXPECT_EQ(pressed[0].key, GLFW_KEY_M);
        EXPECT_TRUE(io.KeysDown[GLFW_KEY_M]);
        EXPECT_TRUE(queue.feed(io).empty());
        EXPECT_FALSE(io.KeysDown[GLFW_KEY_M]);
        EXPECT_EQ(queue.feed(io).size(), 1U);
        EXPECT_TRUE(queue.feed(io).empty());
        EXPECT_FALSE(queue.is_waiting());
    }
    ImGui::DestroyContext();
}

} // namespace
} // namespace springdrive::app
