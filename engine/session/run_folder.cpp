#include "engine/session/run_folder.h"

#include "base/file_names.h"
#include "base/input_error.h"
#include "base/input_file.h"
#include "base/new_file.h"
#include "engine/control/tuning_file.h"
#include "engine/session/run_folder_texts.h"

#include <fmt/core.h>

#include <cerrno>
#include <fstream>
#include <iterator>
#include <optional>
#include <sstream>
#include <string_view>
#include <sys/stat.h>
#include <system_error>

namespace springdrive::session {

namespace {

namespace fs = std::filesystem;

/// Of one text, far above any run: 100,000 tunings take some 15 MB.
constexpr std::size_t kMaxText_bytes = std::size_t{256} << 20U;

/// Of run.json, whose values take some 80 times as much memory as their text.
constexpr std::size_t kMaxFacts_bytes = std::size_t{1} << 20U;

/// A disk with less room is full: the small files would not fit.
constexpr std::size_t kMinRoom_bytes = std::size_t{64} << 10U;

void write_text(const fs::path &file, std::string_view text) {
    if (text.size() > kMaxText_bytes) {
        throw InputError(fmt::format("{}: cannot be written: it would have {} bytes; up to {} can "
                                     "be read again",
                                     file.string(), text.size(), kMaxText_bytes));
    }
    write_file(
        file, [text](std::ostream &out) { out << text; }, Existing::replace);
}

/// Empty if there is no such file.
std::optional<std::string> text_if_any(const fs::path &file,
                                       std::size_t max_bytes = kMaxText_bytes) {
    std::error_code ignored;
    if (fs::symlink_status(file, ignored).type() == fs::file_type::not_found) {
        return std::nullopt;
    }
    check_input_file(file, "a text", max_bytes);
    std::ifstream stream(file, std::ios::binary);
    std::string text{std::istreambuf_iterator<char>(stream), {}};
    if (!stream.is_open() || stream.bad()) {
        throw InputError(file.string() + ": cannot be read; check its permissions");
    }
    return text;
}

std::string text_of_file(const fs::path &file) {
    std::optional<std::string> text = text_if_any(file);
    if (!text) {
        throw InputError(file.string() + ": is missing; the folder of a run needs it");
    }
    return *std::move(text);
}

std::string tuning_text(const control::Tuning &tuning, const std::string &description) {
    std::ostringstream text;
    control::write_tuning_file(text, {tuning, description, std::nullopt});
    return text.str();
}

/// @throw InputError if the new folder cannot be written to; it is then removed.
void check_room_in(const fs::path &folder) {
    try {
        const NewFile tried(folder / "run.json");
        std::ofstream stream(tried.temporary(), std::ios::binary);
        stream << std::string(kMinRoom_bytes, ' ');
        stream.close();
        if (!stream) {
            throw InputError(folder.string() +
                             ": cannot be written to; is the disk full? Free some space");
        }
    } catch (const InputError &) {
        std::error_code ignored;
        fs::remove(folder, ignored);
        throw;
    }
}

} // namespace

RunFolder RunFolder::create(const fs::path &parent) {
    constexpr std::size_t kMaxOfOneSecond = 1000;
    const fs::path name = parent / dated_name("springdrive");
    int error = EEXIST;
    for (std::size_t number = 1; error == EEXIST && number <= kMaxOfOneSecond; ++number) {
        const fs::path folder = numbered_name(name, number);
        error = mkdir(folder.c_str(), 0777) == 0 ? 0 : errno;
        if (error == 0) {
            check_room_in(folder);
            return RunFolder(folder);
        }
    }
    throw InputError(fmt::format("{}: cannot be created: {}; check its folder and permissions",
                                 name.string(), std::generic_category().message(error)));
}

void RunFolder::save(const RunFacts &facts) const {
    for (std::size_t number = 0; number < facts.devices.size(); ++number) {
        write_text(path_ / name_of_device_file(number), facts.devices[number].toml);
    }
    write_text(path_ / "tuning.toml", tuning_text(facts.slots.now(), "active when it was kept"));
    const bool is_a = facts.slots.active() == TuningSlot::a;
    const control::Tuning &a = is_a ? facts.slots.now() : facts.slots.other();
    const control::Tuning &b = is_a ? facts.slots.other() : facts.slots.now();
    write_text(path_ / "slot_a.toml", tuning_text(a, "slot A"));
    write_text(path_ / "slot_b.toml", tuning_text(b, "slot B"));
    write_text(path_ / "tuning_history.csv", journal_csv(facts.journal));
    write_text(path_ / "events.csv", events_csv(facts.events));
    write_text(path_ / "notes.txt", facts.notes);
    write_text(path_ / "run.json", run_json(facts, path_));
}

fs::path RunFolder::next_screenshot() const {
    for (std::size_t number = 1;; ++number) {
        fs::path picture = path_ / fmt::format("screenshot-{}.png", number);
        std::error_code ignored;
        if (!fs::exists(fs::symlink_status(picture, ignored))) {
            return picture;
        }
    }
}

RunFacts read_run(const fs::path &folder) {
    const std::optional<std::string> json = text_if_any(folder / "run.json", kMaxFacts_bytes);
    if (!json) {
        throw InputError(folder.string() + ": has no run.json, so it is not the folder of a run, "
                                           "or the program ended before it was written");
    }
    RunFacts facts;
    read_run_json(*json, folder / "run.json", facts);
    for (std::size_t number = 0; number < facts.devices.size(); ++number) {
        facts.devices[number].toml = text_of_file(folder / name_of_device_file(number));
    }
    facts.notes = text_if_any(folder / "notes.txt").value_or("");
    return facts;
}

} // namespace springdrive::session
