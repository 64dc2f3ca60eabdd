#include "tests/app/study/study_desk.h"

#include <chrono>
#include <cmath>
#include <stdexcept>
#include <thread>

namespace springdrive::testing {

namespace {

constexpr int kExperimenter_px = 640; ///< width of that window; the other one is to its right
constexpr int kParticipant_px = 320;
constexpr int kHeight_px = 400;

std::vector<std::string> with_windows(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "study");
    arguments.insert(arguments.end(),
                     {"--participant-window", "--participant-width",
                      std::to_string(kParticipant_px), "--participant-height", "180", "--width",
                      std::to_string(kExperimenter_px), "--height", std::to_string(kHeight_px),
                      "--scale", "0.8", "--report"});
    return arguments;
}

} // namespace

StudyDesk::StudyDesk(std::vector<std::string> arguments, const std::filesystem::path &folder)
    : display_(kExperimenter_px + kParticipant_px, kHeight_px),
      program_(display_, with_windows(std::move(arguments)), folder), keys_(display_.name()) {
    const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (!keys_.move_window("springdrive", kExperimenter_px, 0)) {
        if (std::chrono::steady_clock::now() > give_up || !program_.is_running()) {
            throw std::runtime_error("there is no window for the participant: " + program_.error());
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    static_cast<void>(look());
    keys_.focus("springdrive");
}

Report StudyDesk::look() {
    program_.send_line("report");
    const std::optional<std::string> line = program_.read_line(std::chrono::seconds(60));
    if (!line) {
        throw std::runtime_error("the windows do not report: " + program_.error());
    }
    return Report(nlohmann::json::parse(*line));
}

void StudyDesk::click_card(const Report &report, std::size_t card) {
    std::size_t number = 0;
    for (const nlohmann::json &item : report.all().at("items")) {
        if (item.at("id") == "participant/choice" && number++ == card) {
            const auto middle = [&item](const char *from, const char *size) {
                return static_cast<int>(
                    std::lround(item.at(from).get<double>() + 0.5 * item.at(size).get<double>()));
            };
            keys_.click(kExperimenter_px + middle("x", "width"), middle("y", "height"));
            return;
        }
    }
    throw std::runtime_error("there is no plate " + std::to_string(card) + ": " + report.texts());
}

void StudyDesk::click(const std::string &id) {
    press_mouse_on(id);
    keys_.button(1, false);
    static_cast<void>(look());
}

void StudyDesk::click_last(const std::string &id) {
    press_mouse_on(id);
    keys_.button(1, false);
}

void StudyDesk::click_participant(int button) { keys_.click(kExperimenter_px + 4, 4, button); }

/// ImGui looks at the mouse once a frame.
void StudyDesk::press_mouse_on(const std::string &id) {
    const Report report = look();
    const nlohmann::json &item = report.item(id);
    const auto middle = [&item](const char *from, const char *size) {
        return static_cast<int>(item.at(from).get<double>() + 0.5 * item.at(size).get<double>());
    };
    keys_.move_to(middle("x", "width"), middle("y", "height"));
    static_cast<void>(look());
    keys_.button(1, true);
    static_cast<void>(look());
}

} // namespace springdrive::testing
