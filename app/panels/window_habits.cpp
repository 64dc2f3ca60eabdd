#include "app/panels/window_habits.h"

#include "app/host/output_dir.h"
#include "base/file_names.h"

#include <fmt/format.h>
#include <imgui.h>

#include <cmath>
#include <filesystem>
#include <iostream>
#include <utility>

namespace springdrive::app {

WindowOrder window_order_of(const KeyPress &key) {
    if (key.with_ctrl) {
        return key.name == "+" || key.name == "="   ? WindowOrder::larger_text
               : key.name == "-"                    ? WindowOrder::smaller_text
               : key.name == "0" && !key.with_shift ? WindowOrder::usual_text
                                                    : WindowOrder::none;
    }
    return key.name == "F1"    ? WindowOrder::toggle_keys
           : key.name == "F9"  ? WindowOrder::take_picture
           : key.name == "F10" ? WindowOrder::toggle_panels
           : key.name == "F11" ? WindowOrder::toggle_full_screen
                               : WindowOrder::none;
}

WindowHabits::WindowHabits(std::filesystem::path settings) : keeper_(std::move(settings)) {}

void WindowHabits::obey(WindowOrder order, Window &window) {
    switch (order) {
    case WindowOrder::larger_text:
        if (window.limits_text()) {
            say(settings().hides_panels
                    ? "no larger text fits into this window"
                    : "no larger text fits into this window: F10 hides the panels, F11 fills the "
                      "screen");
            return;
        }
        set_text_size(next_text_size(settings().text_size, true), window);
        return;
    case WindowOrder::smaller_text:
        set_text_size(next_text_size(settings().text_size, false), window);
        return;
    case WindowOrder::usual_text:
        set_text_size(1.0, window);
        return;
    case WindowOrder::toggle_panels:
        keeper_.now.hides_panels = !settings().hides_panels;
        if (settings().hides_panels) {
            say("F10 shows the panels again");
        }
        return;
    case WindowOrder::toggle_full_screen:
        window.toggle_full_screen();
        return;
    case WindowOrder::take_picture:
        picture_ = unused_name(in_output_dir(dated_name("springdrive") + ".png"));
        return;
    case WindowOrder::reset:
        keeper_.reset();
        window.set_text_size(1.0);
        window.return_to_default_size();
        say("the settings are as in a first run");
        return;
    case WindowOrder::toggle_keys:
    case WindowOrder::tour:
    case WindowOrder::none:
        return;
    }
}

void WindowHabits::set_text_size(double text_size, Window &window) {
    keeper_.now.text_size = text_size;
    window.set_text_size(text_size);
    say(fmt::format("text at {:.0f} %", 100.0 * text_size));
}

void WindowHabits::update(Window &window) {
    window.set_room(settings().hides_panels ? Window::kRoomForScene : Window::kRoomForPanels);
    keeper_.save();
    if (const std::string error = keeper_.take_error(); !error.empty()) {
        std::cerr << "springdrive: " << error << '\n';
        say(error, true);
    }
}

void WindowHabits::finish(const Window &window) {
    if (!window.is_full_screen()) {
        keeper_.now.width = window.size().width;
        keeper_.now.height = window.size().height;
    }
    keeper_.save();
    if (const std::string error = keeper_.take_error(); !error.empty()) {
        std::cerr << "springdrive: " << error << '\n';
    }
}

std::optional<std::filesystem::path> WindowHabits::take_picture() {
    return std::exchange(picture_, {});
}

void WindowHabits::note_picture(const std::filesystem::path &file, const std::string &error) {
    say(error.empty() ? "picture: " + file.lexically_normal().string() +
                            (output_dir() == "." ? " in " + output_dir_text() : "")
                      : error,
        !error.empty());
}

void WindowHabits::say(std::string text, bool is_bad) {
    constexpr double kShort_s = 4.0;
    constexpr double kLong_s = 15.0; // to be read, and acted upon
    notice_ = {std::move(text), is_bad, ImGui::GetTime() + (is_bad ? kLong_s : kShort_s)};
}

const Notice *WindowHabits::notice() const {
    return !notice_.text.empty() && ImGui::GetTime() < notice_.until_s ? &notice_ : nullptr;
}

} // namespace springdrive::app
