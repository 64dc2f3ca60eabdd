#include "tests/support/shown_window.h"

#include <gtest/gtest.h>

#include <chrono>
#include <limits>
#include <stdexcept>
#include <thread>
#include <utility>

namespace springdrive::testing {

namespace {

constexpr std::chrono::seconds kAnswer{60};

constexpr double kQuickly_s = 6.0;     ///< of the frames' time, in about a second
constexpr double kLook_s = 2.0 / 60.0; ///< of the frames' time, see ReportRequests

std::vector<std::string> with_window(std::vector<std::string> arguments, const WindowSize &size,
                                     Pace pace) {
    if (pace == Pace::looks) {
        arguments.insert(arguments.begin(), {"--lockstep", "--unseen"});
    }
    if (size.is_typed) {
        arguments.insert(arguments.begin(),
                         {"--width", std::to_string(size.width), "--height",
                          std::to_string(size.height), "--scale", std::to_string(size.scale)});
    }
    arguments.insert(arguments.begin(), {"demo", "--report"});
    return arguments;
}

} // namespace

const nlohmann::json *Report::find(const std::string &id) const {
    for (const nlohmann::json &item : json_.at("items")) {
        const std::string whole = item.at("id");
        if (whole == id || whole.ends_with("/" + id)) {
            return &item;
        }
    }
    return nullptr;
}

const nlohmann::json &Report::item(const std::string &id) const {
    if (const nlohmann::json *found = find(id)) {
        return *found;
    }
    std::string ids;
    for (const nlohmann::json &item : json_.at("items")) {
        ids += "\n  " + item.at("id").get<std::string>();
    }
    throw std::runtime_error("the window shows no \"" + id + "\"; it shows:" + ids);
}

bool Report::shows(const std::string &text) const {
    return texts().find(text) != std::string::npos;
}

std::string Report::texts() const {
    std::string all;
    for (const nlohmann::json &item : json_.at("items")) {
        all += item.at("text").get<std::string>() + '\n';
    }
    return all;
}

double Report::column(const std::string &name) const {
    const nlohmann::json &value = json_.at("sample").at(name);
    if (value.is_boolean()) {
        return value.get<bool>() ? 1.0 : 0.0;
    }
    return value.is_null() ? std::numeric_limits<double>::quiet_NaN() : value.get<double>();
}

ShownWindow::ShownWindow(std::vector<std::string> arguments, const WindowSize &size,
                         const std::filesystem::path &folder, Pace pace)
    : pace_(pace), display_(size.width, size.height),
      program_(display_, with_window(std::move(arguments), size, pace), folder), person_(display_) {
    if (pace_ == Pace::looks) {
        person_.settle_by([this] { (void)report(); });
    }
    person_.wait_for_window(std::chrono::seconds(30), pace_ == Pace::clock);
}

std::optional<std::string> ShownWindow::report() {
    if (has_ended_) {
        return {};
    }
    program_.send_line("report");
    std::optional<std::string> line = program_.read_line(kAnswer);
    has_ended_ = !line;
    return line;
}

Report ShownWindow::look() {
    const std::optional<std::string> line = report();
    if (!line) {
        throw std::runtime_error("the window does not report: " + program_.error());
    }
    return Report(nlohmann::json::parse(*line));
}

Report ShownWindow::wait_until(const std::function<bool(const Report &)> &holds,
                               const std::string &what, double limit_s) {
    const auto start = std::chrono::steady_clock::now();
    for (double frames_s = 0.0;; frames_s += kLook_s) {
        Report report = look();
        if (holds(report)) {
            return report;
        }
        const bool is_late =
            std::chrono::steady_clock::now() - start > std::chrono::duration<double>(limit_s);
        if (is_late && (pace_ == Pace::clock || frames_s > limit_s)) {
            ADD_FAILURE() << "not within " << limit_s << " s: " << what << "; the window shows\n"
                          << report.texts();
            return report;
        }
        // What other threads do is waited for by the clock.
        if (pace_ == Pace::clock || frames_s > kQuickly_s) {
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
        }
    }
}

void ShownWindow::let_pass(double duration_s) {
    if (pace_ == Pace::clock) {
        std::this_thread::sleep_for(std::chrono::duration<double>(duration_s));
        return;
    }
    for (double frames_s = 0.0; frames_s < duration_s; frames_s += kLook_s) {
        (void)report();
    }
}

void ShownWindow::wait_until_running() {
    wait_until([](const Report &report) { return report.find("Servo") && report.shows("running"); },
               "the motors run");
}

Point ShownWindow::point_in(const std::string &id, float x, float y) {
    const auto place = [&] {
        const Report report = look();
        const nlohmann::json &item = report.item(id);
        return Point{item.at("x").get<float>() + x * item.at("width").get<float>(),
                     item.at("y").get<float>() + y * item.at("height").get<float>()};
    };
    // A person does not press on what moves: a message that appears may shift what is below it.
    constexpr int kMaxFrames = 20;
    Point there = place();
    for (int frame = 0; frame < kMaxFrames; ++frame) {
        const Point before = std::exchange(there, place());
        if (there.x == before.x && there.y == before.y) {
            break;
        }
    }
    return there;
}

void ShownWindow::click(const std::string &id, int button) {
    const Point middle = point_in(id);
    person_.click(middle.x, middle.y, button);
}

void ShownWindow::choose(const std::string &id, const std::string &entry) {
    click(id);
    click(id + "/" + entry);
}

void ShownWindow::enter(const std::string &id, const std::string &text) {
    click(id);
    person_.clear_field();
    person_.type(text);
    person_.key("Return");
}

} // namespace springdrive::testing
