#include "engine/session/run_folder_texts.h"

#include "base/assertions.h"
#include "base/file_names.h"
#include "base/input_error.h"
#include "base/new_file.h"
#include "base/one_line.h"
#include "base/quoting.h"
#include "device/core/calibration.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace springdrive::session {

namespace {

constexpr std::string_view kRunFormat = "springdrive run 1";

[[noreturn]] void refuse_text(const std::filesystem::path &file, const std::string &problem) {
    constexpr std::size_t kMax = 1000;
    throw InputError(file.string() + ": " + one_line(problem, kMax));
}

/// A value of run.json; its readers throw InputError for a value of another type.
class RunValue {
public:
    RunValue(const nlohmann::json &value, const std::filesystem::path &file, std::string place)
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
    const std::filesystem::path &file_;
    std::string place_; ///< "records[1].file"
};

/// What is in the folder by its name alone, all else by its whole path.
std::filesystem::path kept_name(const std::filesystem::path &folder,
                                const std::filesystem::path &file) {
    if (!file.has_parent_path()) {
        return file;
    }
    std::error_code ignored;
    const std::filesystem::path whole = std::filesystem::absolute(file, ignored).lexically_normal();
    const auto resolved = [](const std::filesystem::path &in) {
        return resolved_name(in / "run.json");
    };
    return resolved(whole.parent_path()) == resolved(folder) ? whole.filename() : whole;
}

std::string whole_name(const std::string &file) {
    std::error_code ignored;
    return file.empty() ? file
                        : std::filesystem::absolute(file, ignored).lexically_normal().string();
}

nlohmann::ordered_json json_of_device(const RunDevice &device, std::size_t number) {
    nlohmann::ordered_json effects;
    for (const simulated::PlantEffect &effect : simulated::kPlantEffects) {
        effects[std::string(effect.name)] = device.effects.*effect.on;
    }
    return {{"toml", name_of_device_file(number).string()},
            {"name", device.name},
            {"file", device.file},
            {"seed", device.seed},
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
nlohmann::json parse_run_json(std::string_view text, const std::filesystem::path &file) {
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

} // namespace

std::filesystem::path name_of_device_file(std::size_t number) {
    return numbered_name("device.toml", number + 1);
}

std::string run_json(const RunFacts &facts, const std::filesystem::path &folder) {
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
    for (const std::filesystem::path &picture : facts.screenshots) {
        document["screenshots"].push_back(kept_name(folder, picture).string());
    }
    return json_text(document) + '\n';
}

void read_run_json(std::string_view text, const std::filesystem::path &file, RunFacts &facts) {
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

} // namespace springdrive::session
