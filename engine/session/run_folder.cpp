#include "engine/session/run_folder.h"

#include "base/assertions.h"
#include "base/for_persons.h"
#include "base/input_error.h"
#include "base/input_file.h"
#include "base/new_file.h"
#include "base/text.h"
#include "device/core/device_description.h"
#include "engine/control/tuning_file.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <fstream>
#include <iterator>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <sys/stat.h>
#include <system_error>
#include <utility>
#include <vector>

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

constexpr std::string_view kRunFormat = "springdrive run 1";

[[noreturn]] void refuse_text(const fs::path &file, const std::string &problem) {
    constexpr std::size_t kMax = 1000;
    throw InputError(file.string() + ": " + one_line(problem, kMax));
}

/// A value of run.json; its readers throw InputError for a value of another type.
class RunValue {
public:
    RunValue(const nlohmann::json &value, const fs::path &file, std::string place)
        : value_(value), file_(file), place_(std::move(place)) {}

    [[nodiscard]] RunValue operator[](const std::string &key) const {
        const std::string inside = place_.empty() ? key : place_ + '.' + key;
        require(value_.is_object(), "an object");
        const auto found = value_.find(key);
        if (found == value_.end()) {
            refuse_text(file_, inside + " is missing");
        }
        return {*found, file_, inside};
    }
    [[nodiscard]] std::vector<RunValue> list() const {
        require(value_.is_array(), "a list");
        std::vector<RunValue> values;
        for (const nlohmann::json &value : value_) {
            values.emplace_back(value, file_, fmt::format("{}[{}]", place_, values.size()));
        }
        return values;
    }
    [[nodiscard]] std::string text() const {
        require(value_.is_string(), "a text");
        return value_.get<std::string>();
    }
    [[nodiscard]] double number() const {
        require(value_.is_number() && std::isfinite(value_.get<double>()), "a number");
        return value_.get<double>();
    }
    [[noreturn]] void refuse(const std::string &must_be) const {
        const std::string what = value_.is_string() ? in_quotes(value_.get<std::string>())
                                 : value_.is_number()
                                     ? value_.dump()
                                     : std::string("a value of type ") + value_.type_name();
        refuse_text(file_, fmt::format("{} is {}; it must be {}",
                                       place_.empty() ? "the text" : place_, what, must_be));
    }

private:
    void require(bool is_so, const char *must_be) const {
        if (!is_so) {
            refuse(must_be);
        }
    }

    const nlohmann::json &value_;
    const fs::path &file_;
    std::string place_; ///< "records[1].file"
};

/// What is in the folder by its name alone, all else by its whole path.
fs::path kept_name(const fs::path &folder, const fs::path &file) {
    if (!file.has_parent_path()) {
        return file;
    }
    std::error_code ignored;
    const fs::path whole = fs::absolute(file, ignored).lexically_normal();
    const auto resolved = [](const fs::path &in) { return resolved_name(in / "run.json"); };
    return resolved(whole.parent_path()) == resolved(folder) ? whole.filename() : whole;
}

std::string whole_name(const std::string &file) {
    std::error_code ignored;
    return file.empty() ? file : fs::absolute(file, ignored).lexically_normal().string();
}

/// The name of a device's file in the folder, by its number from 0: "device.toml",
/// "device-2.toml".
fs::path name_of_device_file(std::size_t number) {
    return numbered_name("device.toml", number + 1);
}

nlohmann::ordered_json json_of_device(const RunDevice &device, std::size_t number) {
    nlohmann::ordered_json effects;
    for (const simulated::PlantEffect &effect : simulated::kPlantEffects) {
        effects[std::string(effect.name)] = device.effects.*effect.on;
    }
    return {{"toml", name_of_device_file(number).string()},
            {"name", device.name},
            {"file", device.file},
            {"seed", std::to_string(device.seed)}, // whole: most readers keep 53 of 64 bits
            {"effects", effects},
            {"observes_resistance", device.observes_resistance}};
}

bool is_name_in_folder(const std::string &name) {
    return !name.empty() && name != "." && name != ".." &&
           name.find_first_of(std::string_view("/\0", 2)) == std::string::npos;
}

/// The names of the device files, by their numbers.
std::vector<std::string> device_files_from_json(const RunValue &list) {
    std::vector<std::string> files;
    for (const RunValue &device : list.list()) {
        const std::string name = name_of_device_file(files.size()).string();
        if (device["toml"].text() != name) {
            device["toml"].refuse(in_quotes(name));
        }
        files.push_back(name);
    }
    return files;
}

RunRecord record_from_json(const RunValue &value, const std::vector<std::string> &device_files) {
    const std::string file = value["file"].text();
    if (!is_name_in_folder(file) &&
        (!file.starts_with('/') || file.find('\0') != std::string::npos)) {
        value["file"].refuse("the name of a file in this folder, or a path from /");
    }
    const auto device = std::ranges::find(device_files, value["device"].text());
    if (device == device_files.end()) {
        value["device"].refuse("the file of one of the devices");
    }
    return {file, value["start_s"].number(),
            static_cast<std::size_t>(device - device_files.begin())};
}

/// @throw InputError for what is no JSON, or a run of another version
nlohmann::json parse_run_json(std::string_view text, const fs::path &file) {
    nlohmann::json document;
    try {
        document = nlohmann::json::parse(text.begin(), text.end());
    } catch (const nlohmann::json::exception &error) { // "[json.exception.…] parse error at …"
        const std::string_view what = error.what();
        const std::size_t prefix = what.find("] ");
        refuse_text(file, "is no JSON: " + std::string(prefix == std::string_view::npos
                                                           ? what
                                                           : what.substr(prefix + 2)));
    }
    const RunValue format = RunValue(document, file, "")["format"];
    if (format.text() != kRunFormat) {
        format.refuse('"' + std::string(kRunFormat) + "\"; read it with the version that wrote it");
    }
    return document;
}

/// All but what has a file of its own. @pre each record's device is one of `facts.devices`
/// @param folder  of the run: what is in it is named without its path
std::string run_json(const RunFacts &facts, const fs::path &folder) {
    nlohmann::ordered_json document;
    document["format"] = kRunFormat;
    document["software"] = facts.software;
    document["started_utc"] = device::text_of_utc(facts.started.time_since_epoch().count());
    document["kept_utc"] = device::text_of_utc(facts.kept.time_since_epoch().count());
    document["until_s"] = facts.until_s;
    document["servo_hz"] = facts.servo_hz;
    document["delay_periods"] = facts.delay_periods;
    document["devices"] = nlohmann::ordered_json::array();
    for (const RunDevice &device : facts.devices) {
        document["devices"].push_back(json_of_device(device, document["devices"].size()));
    }
    document["scene"] = {{"file", whole_name(facts.scene.file)},
                         {"sha256", facts.scene.sha256},
                         {"triangles", facts.scene.triangles}};
    document["active_slot"] = name_of(facts.slots.active());
    document["records"] = nlohmann::ordered_json::array();
    for (const RunRecord &record : facts.records) {
        SPRINGDRIVE_ASSERT(record.device < facts.devices.size());
        document["records"].push_back({{"file", kept_name(folder, record.file).string()},
                                       {"start_s", record.start_s},
                                       {"device", name_of_device_file(record.device).string()}});
    }
    document["screenshots"] = nlohmann::ordered_json::array();
    for (const fs::path &picture : facts.screenshots) {
        document["screenshots"].push_back(kept_name(folder, picture).string());
    }
    return json_text(document) + '\n';
}

/// Fills times, scene, records and the number of devices from what `run_json` wrote.
/// @throw InputError, which names `file`, for a text that is not of its format
void read_run_json(std::string_view text, const fs::path &file, RunFacts &facts) {
    const nlohmann::json parsed = parse_run_json(text, file);
    const RunValue document(parsed, file, "");
    facts.until_s = document["until_s"].number();
    const std::vector<std::string> device_files = device_files_from_json(document["devices"]);
    facts.devices.resize(device_files.size());
    facts.scene.file = document["scene"]["file"].text();
    facts.scene.sha256 = document["scene"]["sha256"].text();
    for (const RunValue &record : document["records"].list()) {
        facts.records.push_back(record_from_json(record, device_files));
    }
}

/// One line per event: times, name, and all parameters, named as in tuning files.
std::string journal_csv(const std::vector<TuningEvent> &journal) {
    std::string text = "began_s,time_s,what";
    for (const control::Parameter &parameter : control::kParameters) {
        text += fmt::format(",{}", parameter.name);
    }
    text += ",map,alpha_mode\n";
    for (const TuningEvent &event : journal) {
        text += fmt::format("{},{},{}", csv_cell(event.began_s), csv_cell(event.time_s),
                            csv_cell(event.what));
        for (const control::Parameter &parameter : control::kParameters) {
            text += ',' + csv_cell(event.tuning.*parameter.value);
        }
        text += fmt::format(",{},{}\n", control::name_of(event.tuning.map),
                            control::name_of(event.tuning.alpha_mode));
    }
    return text;
}

std::string events_csv(const std::vector<RunEvent> &events) {
    std::string text = "time_s,text\n";
    for (const RunEvent &event : events) {
        text += fmt::format("{},{}\n", csv_cell(event.time_s), csv_cell(event.text));
    }
    return text;
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
    write_text(path_ / "tuning_history.csv", csv_for_persons(journal_csv(facts.journal)));
    write_text(path_ / "events.csv", csv_for_persons(events_csv(facts.events)));
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
