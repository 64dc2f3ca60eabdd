#include "app/panels/tuning_files.h"

#include "app/host/asset_folder.h"
#include "app/host/output.h"
#include "app/host/output_dir.h"
#include "base/input_error.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <fcntl.h>
#include <system_error>
#include <utility>

namespace springdrive::app {

namespace {

void add_tunings_in(const std::filesystem::path &folder, bool is_own,
                    std::vector<TuningFiles::Entry> &entries) {
    std::error_code ignored;
    std::vector<std::filesystem::path> files;
    for (const auto &entry : std::filesystem::directory_iterator(folder, ignored)) {
        if (entry.path().extension() == ".toml" && entry.is_regular_file(ignored)) {
            files.push_back(entry.path());
        }
    }
    std::ranges::sort(files);
    for (const std::filesystem::path &file : files) {
        try {
            const std::string name = file.stem().string();
            entries.push_back({file, is_own ? name : "(" + name + ")",
                               control::read_whole_tuning_file(file), is_own});
        } catch (const InputError &) {
            // Another kind of file, such as a device: not offered.
        }
    }
}

/// A file of that name in the own folder. @throw InputError for a name that would lead elsewhere
std::filesystem::path file_of(const std::string &name) {
    const bool is_blank = name.find_first_not_of(' ') == std::string::npos;
    if (is_blank || name.find('/') != std::string::npos || name.front() == '.') {
        throw InputError("type a name without / to save the tuning in " + output_dir_text());
    }
    return in_output_dir(name.ends_with(".toml") ? name : name + ".toml");
}

} // namespace

std::string preset_file(std::string_view label, double servo_hz, double delay_periods) {
    // A rate of 1000 Hz is kept as a period of 1 ms, and may return as 999.99….
    constexpr double kRoundOff = 1.0 + 1e-9;
    std::string file;
    for (const Preset &preset : kPresets) {
        const bool fits = preset.min_servo_hz == 0.0 ||
                          (servo_hz * kRoundOff >= preset.min_servo_hz && delay_periods == 0.0);
        if (preset.label == label && fits) {
            file = preset.file;
        }
    }
    return file;
}

void TuningFiles::refresh() {
    entries_.clear();
    add_tunings_in(output_dir(), true, entries_);
    add_tunings_in(asset_folder() / "tunings", false, entries_);
}

std::string TuningFiles::save(const std::string &name, const control::Tuning &tuning) {
    try {
        std::string message = save_as(file_of(name), [&tuning](std::ostream &out) {
            control::write_tuning_file(out, {tuning, "saved in the window", std::nullopt});
        });
        refresh();
        return message;
    } catch (const InputError &error) {
        return error.what();
    }
}

/// The entry is a copy, as those of the list are renewed.
std::string TuningFiles::rename(Entry entry, const std::string &name) {
    try {
        const std::filesystem::path from = std::move(entry.file);
        const std::filesystem::path to = file_of(name);
        // Not std::filesystem::rename, which replaces an existing file.
        if (renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) != 0) {
            const std::error_code why(errno, std::generic_category());
            throw InputError(to.string() + (why == std::errc::file_exists
                                                ? ": exists already; choose another name"
                                                : ": " + why.message()));
        }
        refresh();
        return from.filename().string() + " is now " + to.string();
    } catch (const InputError &error) {
        return error.what();
    }
}

} // namespace springdrive::app
