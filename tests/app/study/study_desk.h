// A sitting in its two real windows, with somebody at the participant's keyboard and mouse and
// somebody at the experimenter's: on a virtual display, by events of the X server.
#pragma once

#include "tests/support/pressed_keys.h"
#include "tests/support/running_program.h"
#include "tests/support/shown_window.h"
#include "tests/support/virtual_display.h"

#include <chrono>
#include <cmath>
#include <filesystem>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace springdrive::testing {

class StudyDesk {
public:
    /// Starts `springdrive study` with these arguments, puts the windows side by side, and gives
    /// the participant's the keyboard, as a window manager would.
    StudyDesk(std::vector<std::string> arguments, const std::filesystem::path &folder)
        : display_(kExperimenter_px + kParticipant_px, kHeight_px),
          program_(display_, with_windows(std::move(arguments)), folder), keys_(display_.name()) {
        const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(60);
        while (!keys_.move_window("springdrive", kExperimenter_px, 0)) {
            if (std::chrono::steady_clock::now() > give_up || !program_.is_running()) {
                throw std::runtime_error("there is no window for the participant: " +
                                         program_.error());
            }
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
        }
        static_cast<void>(look());
        keys_.focus("springdrive");
    }

    [[nodiscard]] Report look() {
        program_.send_line("report");
        const std::optional<std::string> line = program_.read_line(std::chrono::seconds(60));
        if (!line) {
            throw std::runtime_error("the windows do not report: " + program_.error());
        }
        return Report(nlohmann::json::parse(*line));
    }

    /// The participant's keyboard: the key is pressed and released at once.
    void press(const std::string &key) { keys_.tap(key); }
    /// The participant's mouse: on the plate with this number, from 0.
    void click_card(const Report &report, std::size_t card) {
        std::size_t number = 0;
        for (const nlohmann::json &item : report.all().at("items")) {
            if (item.at("id") == "participant/choice" && number++ == card) {
                keys_.click(kExperimenter_px + middle_px(item, "x", "width"),
                            middle_px(item, "y", "height"));
                return;
            }
        }
        throw std::runtime_error("there is no plate " + std::to_string(card) + ": " +
                                 report.texts());
    }
    /// The experimenter's mouse; the keyboard stays the participant's.
    void click(const std::string &id) {
        click_last(id);
        static_cast<void>(look());
    }
    /// The same, with a button after which the windows are gone.
    void click_last(const std::string &id) { // ImGui looks at the mouse once a frame
        const Report report = look();
        const nlohmann::json &item = report.item(id);
        keys_.move_to(middle_px(item, "x", "width"), middle_px(item, "y", "height"));
        static_cast<void>(look());
        keys_.button(1, true);
        static_cast<void>(look());
        keys_.button(1, false);
    }
    /// The participant's mouse, beside all plates; X11's buttons.
    void click_participant(int button) { keys_.click(kExperimenter_px + 4, 4, button); }

    /// Of all windows that are seen at present.
    [[nodiscard]] std::set<std::string> window_titles() const { return keys_.window_titles(); }

    [[nodiscard]] RunningProgram &program() { return program_; }

private:
    static constexpr int kExperimenter_px = 640; ///< of that window; the other is to its right
    static constexpr int kParticipant_px = 320;
    static constexpr int kHeight_px = 400;

    static std::vector<std::string> with_windows(std::vector<std::string> arguments) {
        arguments.insert(arguments.begin(), "study");
        arguments.insert(arguments.end(),
                         {"--participant-window", "--participant-width",
                          std::to_string(kParticipant_px), "--participant-height", "180", "--width",
                          std::to_string(kExperimenter_px), "--height", std::to_string(kHeight_px),
                          "--scale", "0.8", "--report"});
        return arguments;
    }

    static int middle_px(const nlohmann::json &item, const char *from, const char *size) {
        return static_cast<int>(
            std::lround(item.at(from).get<double>() + 0.5 * item.at(size).get<double>()));
    }

    VirtualDisplay display_;
    RunningProgram program_;
    PressedKeys keys_;
};

} // namespace springdrive::testing
