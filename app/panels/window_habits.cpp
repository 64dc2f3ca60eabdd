#include "app/panels/window_habits.h"

#include "app/host/folders.h"
#include "base/field_toml.h"
#include "base/input_error.h"
#include "base/new_file.h"
#include "base/text.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <iterator>
#include <ostream>
#include <string_view>
#include <system_error>
#include <utility>

namespace springdrive::app {

namespace {

namespace fs = std::filesystem;

constexpr std::array<double, 10> kTextSizes{kMinTextSize, 0.67, 0.8, 1.0, 1.25,
                                            1.5,          1.75, 2.0, 2.5, kMaxTextSize};

/// The words of what can be drawn.
constexpr auto kThingWords = [] {
    std::array<std::string_view, kThings.size()> words;
    std::ranges::transform(kThings, words.begin(), &OverlayStyle::word);
    return words;
}();

constexpr auto kSettingsFields = std::to_array<Field<Settings>>({
    {"text_size", &Settings::text_size, "of text and panels, times the display's scale",
     kMinTextSize, kMaxTextSize},
    {"hides_panels", &Settings::hides_panels, "scene and read-outs only"},
    {"dismissed_start", &Settings::dismissed_start, "the plate of the first minute"},
    {"opens_legend", &Settings::opens_legend, "what is drawn in the scene, by name"},
});

constexpr auto kWindowFields = std::to_array<Field<Settings>>({
    {"width", &Settings::width, "of the window in pixels", 320.0, 16'384.0, "", kRequired},
    {"height", &Settings::height, "of the window in pixels", 240.0, 16'384.0, "", kRequired},
});

/// Every key may be missing, but of width and height none or both.
Settings read_all(StrictTomlTable table) {
    Settings settings;
    read(table, kSettingsFields, settings);
    if (table.has_optional("width") || table.has_optional("height")) {
        read(table, kWindowFields, settings);
    }
    if (table.has_optional("drawn")) {
        const std::vector<std::size_t> drawn = table.choices("drawn", kThingWords);
        for (std::size_t i = 0; i < kThings.size(); ++i) {
            settings.shown.show(kThings[i].thing, std::ranges::count(drawn, i) > 0);
        }
    }
    if (table.has_optional("recent")) {
        for (const std::string &recent : table.texts("recent", Settings::kMaxRecent)) {
            settings.recent.emplace_back(recent);
            if (!settings.recent.back().is_absolute()) {
                table.refuse("recent",
                             "has " + in_quotes(recent) + "; each must be an absolute path");
            }
        }
    }
    table.refuse_unknown_keys();
    return settings;
}

} // namespace

double next_text_size(double now, bool larger) {
    constexpr double kSame = 1e-6;
    if (larger) {
        const auto *const next = std::ranges::upper_bound(kTextSizes, now + kSame);
        return next == kTextSizes.end() ? kTextSizes.back() : *next;
    }
    const auto *const next = std::ranges::lower_bound(kTextSizes, now - kSame);
    return next == kTextSizes.begin() ? kTextSizes.front() : *(next - 1);
}

fs::path settings_file() {
    const fs::path folder = user_folder("XDG_CONFIG_HOME", ".config");
    return folder.empty() ? folder : folder / "settings.toml";
}

Settings read_settings(const fs::path &file) {
    std::error_code ignored;
    if (file.empty() || !fs::exists(fs::symlink_status(file, ignored))) {
        return {};
    }
    try {
        return read_all(StrictTomlTable::read(file));
    } catch (const InputError &error) {
        throw InputError(std::string(error.what()) +
                         "; springdrive demo --reset-settings begins anew");
    }
}

void write_settings(const fs::path &file, const Settings &settings) {
    std::error_code ignored; // without the folder, the file cannot be created, which is said
    fs::create_directories(file.parent_path(), ignored);
    write_file(
        file,
        [&](std::ostream &out) {
            write(out, kSettingsFields, settings);
            if (settings.width > 0) {
                write(out, kWindowFields, settings);
            }
            if (settings.shown != ShownThings()) {
                std::vector<std::string_view> drawn;
                for (const OverlayStyle &look : kThings) {
                    if (settings.shown.shows(look.thing)) {
                        drawn.emplace_back(look.word);
                    }
                }
                out << "drawn = " << toml_list(drawn) << '\n';
            }
            if (!settings.recent.empty()) {
                std::vector<std::string> recent;
                std::ranges::transform(settings.recent, std::back_inserter(recent),
                                       [](const fs::path &path) { return path.string(); });
                out << "recent = " << toml_list(recent) << '\n';
            }
        },
        Existing::replace);
}

void note_recent(Settings &settings, const fs::path &file) {
    std::error_code failed;
    const fs::path whole = fs::absolute(file, failed).lexically_normal();
    if (failed || file.empty() || !is_utf8(whole.string())) {
        return;
    }
    std::erase(settings.recent, whole);
    settings.recent.insert(settings.recent.begin(), whole);
    settings.recent.resize(std::min(settings.recent.size(), Settings::kMaxRecent));
}

SettingsKeeper::SettingsKeeper(fs::path file) : file_(std::move(file)) {
    error_ = error_text_of([this] { now = read_settings(file_); });
    is_damaged_ = !error_.empty();
    saved_ = now;
}

void SettingsKeeper::save() {
    if (!remembers() || now == saved_) {
        return;
    }
    // Also of what fails: it is said once, not in every frame.
    saved_ = now;
    const std::string error = error_text_of([this] {
        set_damaged_aside();
        write_settings(file_, now);
    });
    if (!error.empty()) {
        error_ = "the window's settings are not remembered: " + error;
    }
}

void SettingsKeeper::reset() {
    now = {};
    saved_ = now;
    std::error_code failed;
    std::filesystem::remove(file_, failed);
    is_damaged_ = is_damaged_ && failed;
    if (failed) {
        error_ = fmt::format("{}: cannot be removed: {}", file_.string(), failed.message());
    }
}

/// A person may have written it: it is kept beside the new one.
void SettingsKeeper::set_damaged_aside() {
    if (!is_damaged_) {
        return;
    }
    std::error_code failed;
    fs::rename(file_, unused_name(fs::path(file_).replace_extension(".damaged")), failed);
    if (failed) {
        throw InputError(
            fmt::format("{}: cannot be renamed: {}", file_.string(), failed.message()));
    }
    is_damaged_ = false;
}

std::string SettingsKeeper::take_error() { return std::exchange(error_, {}); }

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
