#include "app/panels/settings.h"

#include "app/host/user_folder.h"
#include "base/complaint.h"
#include "base/file_names.h"
#include "base/input_error.h"
#include "base/new_file.h"
#include "base/number_in.h"
#include "base/one_line.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <functional>
#include <ostream>
#include <string_view>
#include <system_error>
#include <utility>

namespace springdrive::app {

namespace {

namespace fs = std::filesystem;

constexpr const char *kSettingsHeading = "springdrive settings 1";

constexpr std::array<double, 10> kTextSizes{
    kLeastTextSize, 0.67, 0.8, 1.0, 1.25, 1.5, 1.75, 2.0, 2.5, kGreatestTextSize};

/// Reads all of `text` as a number in that range.
template <typename Number>
bool read_number(std::string_view text, Number least, Number greatest, Number &number) {
    const auto read = number_in<Number>(text);
    if (!read || !(*read >= least && *read <= greatest)) {
        return false;
    }
    number = *read;
    return true;
}

bool read_window(std::string_view text, Settings &settings) {
    const std::size_t gap = text.find(' ');
    return gap != std::string_view::npos &&
           read_number(text.substr(0, gap), 320, 16384, settings.width) &&
           read_number(text.substr(gap + 1), 240, 16384, settings.height);
}

bool read_word(std::string_view text, std::string_view word, bool &is_so) {
    is_so = text == word;
    return is_so;
}

bool read_recent(std::string_view text, Settings &settings) {
    settings.recent.emplace_back(text);
    return settings.recent.back().is_absolute() && settings.recent.size() <= Settings::kMostRecent;
}

/// The words of things that are drawn, or "nothing".
bool read_drawn(std::string_view text, Settings &settings) {
    for (const ThingLook &look : kThings) {
        settings.shown.show(look.thing, false);
    }
    if (text == "nothing") {
        return true;
    }
    for (std::size_t from = 0; from <= text.size();) {
        const std::size_t gap = std::min(text.find(' ', from), text.size());
        const auto *const look =
            std::ranges::find(kThings, text.substr(from, gap - from), &ThingLook::word);
        if (look == kThings.end() || settings.shown.shows(look->thing)) {
            return false;
        }
        settings.shown.show(look->thing, true);
        from = gap + 1;
    }
    return true;
}

std::string drawn_words(const ShownThings &shown) {
    std::string words;
    for (const ThingLook &look : kThings) {
        if (shown.shows(look.thing)) {
            words.append(words.empty() ? "" : " ").append(look.word);
        }
    }
    return words.empty() ? "nothing" : words;
}

/// A line: its first word, what may follow, and how that is read.
struct SettingsLine {
    std::string_view word;
    const char *allowed;
    bool (*read)(std::string_view, Settings &);
};

constexpr std::array<SettingsLine, 7> kSettingsLines{{
    {"text_size", "a number from 0.5 to 3",
     [](std::string_view text, Settings &settings) {
         return read_number(text, kLeastTextSize, kGreatestTextSize, settings.text_size);
     }},
    {"window", "two numbers of pixels, from 320 240 to 16384 16384", read_window},
    {"panels", "hidden",
     [](std::string_view text, Settings &settings) {
         return read_word(text, "hidden", settings.hides_panels);
     }},
    {"start", "dismissed",
     [](std::string_view text, Settings &settings) {
         return read_word(text, "dismissed", settings.dismissed_start);
     }},
    {"legend", "open",
     [](std::string_view text, Settings &settings) {
         return read_word(text, "open", settings.opens_legend);
     }},
    {"drawn", "names of what is drawn, each once, or nothing", read_drawn},
    {"recent", "an absolute path, in at most 8 lines", read_recent},
}};

constexpr const char *kRemedy = "; springdrive demo --reset-settings begins anew";

void read_line(const std::string &where, std::string_view line, Settings &settings) {
    const std::size_t gap = line.find(' ');
    const std::string_view word = line.substr(0, gap);
    const auto *const known = std::ranges::find(kSettingsLines, word, &SettingsLine::word);
    if (known == kSettingsLines.end()) {
        throw InputError(
            fmt::format("{}: {} is no setting{}", where, in_quotes(std::string(word)), kRemedy));
    }
    if (gap == std::string_view::npos || !known->read(line.substr(gap + 1), settings)) {
        throw InputError(
            fmt::format("{}: {} must be followed by {}{}", where, word, known->allowed, kRemedy));
    }
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
    return folder.empty() ? folder : folder / "settings";
}

Settings read_settings(const fs::path &file) {
    std::error_code ignored;
    if (file.empty() || !fs::exists(fs::symlink_status(file, ignored))) {
        return {};
    }
    std::ifstream stream(file);
    std::string line;
    Settings settings;
    if (!fs::is_regular_file(file, ignored) || !stream) {
        throw InputError(fmt::format("{}: cannot be read{}", file.string(), kRemedy));
    }
    if (!std::getline(stream, line) || line != kSettingsHeading) {
        throw InputError(
            fmt::format("{}:1: must be '{}'{}", file.string(), kSettingsHeading, kRemedy));
    }
    for (int number = 2; std::getline(stream, line); ++number) {
        read_line(fmt::format("{}:{}", file.string(), number), line, settings);
    }
    return settings;
}

void write_settings(const fs::path &file, const Settings &settings) {
    std::error_code ignored; // without the folder, the file cannot be created, which is said
    fs::create_directories(file.parent_path(), ignored);
    write_file(
        file,
        [&](std::ostream &out) {
            out << kSettingsHeading << '\n'
                << "text_size " << shortest_text(settings.text_size) << '\n';
            if (settings.width > 0) {
                out << "window " << settings.width << ' ' << settings.height << '\n';
            }
            out << (settings.hides_panels ? "panels hidden\n" : "")
                << (settings.dismissed_start ? "start dismissed\n" : "")
                << (settings.opens_legend ? "legend open\n" : "");
            if (settings.shown != ShownThings()) {
                out << "drawn " << drawn_words(settings.shown) << '\n';
            }
            for (const fs::path &recent : settings.recent) {
                out << "recent " << recent.string() << '\n';
            }
        },
        Existing::replace);
}

void note_recent(Settings &settings, const fs::path &file) {
    std::error_code failed;
    const fs::path whole = fs::absolute(file, failed).lexically_normal();
    if (failed || file.empty() || whole.string().find('\n') != std::string::npos) {
        return;
    }
    std::erase(settings.recent, whole);
    settings.recent.insert(settings.recent.begin(), whole);
    settings.recent.resize(std::min(settings.recent.size(), Settings::kMostRecent));
}

SettingsKeeper::SettingsKeeper(fs::path file) : file_(std::move(file)) {
    complaint_ = complaint_of([this] { now = read_settings(file_); });
    is_damaged_ = !complaint_.empty();
    saved_ = now;
}

void SettingsKeeper::save() {
    if (!remembers() || now == saved_) {
        return;
    }
    // Also of what fails: it is said once, not in every frame.
    saved_ = now;
    const std::string complaint = complaint_of([this] {
        set_damaged_aside();
        write_settings(file_, now);
    });
    if (!complaint.empty()) {
        complaint_ = "the window's settings are not remembered: " + complaint;
    }
}

void SettingsKeeper::reset() {
    now = {};
    saved_ = now;
    std::error_code failed;
    std::filesystem::remove(file_, failed);
    is_damaged_ = is_damaged_ && failed;
    if (failed) {
        complaint_ = fmt::format("{}: cannot be removed: {}", file_.string(), failed.message());
    }
}

/// A person may have written it: it is kept beside the new one.
void SettingsKeeper::set_damaged_aside() {
    if (!is_damaged_) {
        return;
    }
    std::error_code failed;
    fs::rename(file_, unused_name(file_.string() + ".damaged"), failed);
    if (failed) {
        throw InputError(
            fmt::format("{}: cannot be renamed: {}", file_.string(), failed.message()));
    }
    is_damaged_ = false;
}

std::string SettingsKeeper::take_complaint() { return std::exchange(complaint_, {}); }

} // namespace springdrive::app
