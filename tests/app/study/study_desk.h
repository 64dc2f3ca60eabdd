// A sitting in its two real windows, with somebody at the participant's keyboard and mouse and
// somebody at the experimenter's: on a virtual display, by events of the X server.
#pragma once

#include "tests/support/pressed_keys.h"
#include "tests/support/running_program.h"
#include "tests/support/shown_window.h"
#include "tests/support/virtual_display.h"

#include <filesystem>
#include <set>
#include <string>
#include <vector>

namespace springdrive::testing {

class StudyDesk {
public:
    /// Starts `springdrive study` with these arguments, puts the windows side by side, and gives
    /// the participant's the keyboard, as a window manager would.
    StudyDesk(std::vector<std::string> arguments, const std::filesystem::path &folder);

    [[nodiscard]] Report look();

    /// The participant's keyboard: the key is pressed and released at once.
    void press(const std::string &key) { keys_.tap(key); }
    /// The participant's mouse: on the plate with this number, from 0.
    void click_card(const Report &report, std::size_t card);
    /// The experimenter's mouse; the keyboard stays the participant's.
    void click(const std::string &id);
    /// The same, with a button after which the windows are gone.
    void click_last(const std::string &id);
    /// The participant's mouse, beside all plates; X11's buttons.
    void click_participant(int button);

    /// Of all windows that are seen at present.
    [[nodiscard]] std::set<std::string> window_titles() const { return keys_.window_titles(); }

    [[nodiscard]] RunningProgram &program() { return program_; }

private:
    void press_mouse_on(const std::string &id);

    VirtualDisplay display_;
    RunningProgram program_;
    PressedKeys keys_;
};

} // namespace springdrive::testing
