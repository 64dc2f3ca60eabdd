#include "engine/session/run_folder_texts.h"

#include "base/assertions.h"
#include "base/file_names.h"
#include "base/input_error.h"
#include "base/new_file.h"
#include "base/number_in.h"
#include "base/one_line.h"
#include "base/print.h"
#include "base/quoting.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <iomanip>
#include <optional>
#include <sstream>
#include <utility>

namespace springdrive::session {

namespace {

constexpr std::string_view kRunFormat = "springdrive run 1";
constexpr const char *kUtcFormat = "%Y-%m-%dT%H:%M:%SZ";

[[noreturn]] void refuse_text(const std::filesystem::path &file, const std::string &problem) {
    constexpr std::size_t kLongest = 1000;
    throw InputError(file.string() + ": " + one_line(problem, kLongest));
}

std::string utc_text(std::chrono::sys_seconds time) {
    const std::time_t seconds = std::chrono::system_clock::to_time_t(time);
    std::tm parts{};
    gmtime_r(&seconds, &parts);
    std::ostringstream text;
    text << std::put_time(&parts, kUtcFormat);
    return text.str();
}

std::optional<std::chrono::sys_seconds> utc_time(const std::string &text) {
    std::tm parts{};
    std::istringstream stream(text);
    stream >> std::get_time(&parts, kUtcFormat);
    if (stream.fail()) {
        return std::nullopt;
    }
    return std::chrono::floor<std::chrono::seconds>(
        std::chrono::system_clock::from_time_t(timegm(&parts)));
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
    [[nodiscard]] bool has(const std::string &key) const {
        require(value_.is_object(), "an object");
        return value_.contains(key);
    }
    [[nodiscard]] std::string text() const {
        require(value_.is_string(), "a text");
        return value_.get<std::string>();
    }
    [[nodiscard]] double number() const {
        require(value_.is_number() && std::isfinite(value_.get<double>()), "a number");
        return value_.get<double>();
    }
    [[nodiscard]] std::uint64_t count() const {
        require(value_.is_number_unsigned(), "a whole number from 0");
        return value_.get<std::uint64_t>();
    }
    [[nodiscard]] bool flag() const {
        require(value_.is_boolean(), "true or false");
        return value_.get<bool>();
    }
    [[nodiscard]] std::chrono::sys_seconds time() const {
        const std::optional<std::chrono::sys_seconds> time = utc_time(text());
        if (!time) {
            refuse("a time such as 2024-05-31T12:34:56Z");
        }
        return *time;
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

RunDevice device_from_json(const RunValue &value) {
    RunDevice device;
    device.name = value["name"].text();
    device.file = value["file"].text();
    device.seed = value["seed"].count();
    const RunValue effects = value["effects"];
    for (const simulated::PlantEffect &effect : simulated::kPlantEffects) {
        const std::string name(effect.name);
        if (effects.has(name)) { // else it was written before there was such an effect
            device.effects.*effect.on = effects[name].flag();
        }
    }
    device.observes_resistance = value["observes_resistance"].flag();
    return device;
}

bool is_name_in_folder(const std::string &name) {
    return !name.empty() && name != "." && name != ".." &&
           name.find_first_of(std::string_view("/\0", 2)) == std::string::npos;
}

std::filesystem::path picture_from_json(const RunValue &value) {
    const std::string name = value.text();
    if (!is_name_in_folder(name)) {
        value.refuse("the name of a file in this folder");
    }
    return name;
}

RunRecord record_from_json(const RunValue &value, std::size_t devices) {
    const std::string file = value["file"].text();
    if (!is_name_in_folder(file) &&
        (!file.starts_with('/') || file.find('\0') != std::string::npos)) {
        value["file"].refuse("the name of a file in this folder, or a path from /");
    }
    const std::string device = value["device"].text();
    for (std::size_t number = 0; number < devices; ++number) {
        if (name_of_device_file(number) == device) {
            return {file, value["start_s"].number(), number};
        }
    }
    value["device"].refuse("the file of one of the devices");
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

/// A line of a CSV file: several, if a cell has line breaks.
struct CsvLine {
    std::size_t number = 0; ///< from 1
    std::vector<std::string> cells;
};

/// Takes a CSV file apart, as `csv_cell` wrote it, or a spreadsheet.
class CsvReader {
public:
    CsvReader(std::string_view text, const std::filesystem::path &file)
        : text_(text), file_(file) {}

    /// False at the end.
    bool next(CsvLine &line) {
        if (at_ >= text_.size()) {
            return false;
        }
        line = {number_, {}};
        do {
            line.cells.push_back(unguard_formula(cell()));
        } while (take(','));
        take('\r');
        if (!take('\n') && at_ < text_.size()) {
            refuse_text(file_, fmt::format("line {}: a comma is missing after a quote", number_));
        }
        return true;
    }

private:
    bool take(char wanted) {
        if (at_ >= text_.size() || text_[at_] != wanted) {
            return false;
        }
        number_ += wanted == '\n' ? 1U : 0U;
        ++at_;
        return true;
    }

    std::string cell() {
        if (take('"')) {
            return quoted();
        }
        const std::size_t end = std::min(text_.find_first_of(",\r\n", at_), text_.size());
        return std::string(text_.substr(std::exchange(at_, end), end - at_));
    }

    std::string quoted() {
        const std::size_t began = number_;
        std::string cell;
        while (at_ < text_.size()) {
            const char next = text_[at_];
            take(next);
            if (next == '"' && !take('"')) {
                return cell;
            }
            cell += next;
        }
        refuse_text(file_, fmt::format("line {}: a quote is not closed", began));
    }

    std::string_view text_;
    const std::filesystem::path &file_;
    std::size_t at_ = 0;
    std::size_t number_ = 1;
};

/// The lines after the first one, which must be `title`.
std::vector<CsvLine> csv_lines(std::string_view text, const std::filesystem::path &file,
                               const std::vector<std::string> &title) {
    CsvReader reader(text, file);
    CsvLine line;
    if (!reader.next(line) || line.cells != title) {
        refuse_text(file, fmt::format("its first line must be {}", fmt::join(title, ",")));
    }
    std::vector<CsvLine> lines;
    while (reader.next(line)) {
        if (line.cells.size() == 1 && line.cells.front().empty()) {
            continue; // an empty line
        }
        if (line.cells.size() != title.size()) {
            refuse_text(file, fmt::format("line {}: has {} cells; it must have {}", line.number,
                                          line.cells.size(), title.size()));
        }
        lines.push_back(line);
    }
    return lines;
}

[[noreturn]] void refuse_cell(const std::filesystem::path &file, const CsvLine &line,
                              std::size_t cell, const std::string &must_be) {
    refuse_text(file, fmt::format("line {}: cell {} is {}; it must be {}", line.number, cell + 1,
                                  in_quotes(line.cells[cell]), must_be));
}

double csv_number(const std::filesystem::path &file, const CsvLine &line, std::size_t cell) {
    const auto number = number_in<double>(line.cells[cell]);
    if (!number || !std::isfinite(*number)) {
        refuse_cell(file, line, cell, "a number");
    }
    return *number;
}

const std::vector<std::string> &journal_title() {
    static const std::vector<std::string> title = [] {
        std::vector<std::string> names{"began_s", "time_s", "what"};
        for (const control::Parameter &parameter : control::kParameters) {
            names.emplace_back(parameter.name);
        }
        names.insert(names.end(), {"map", "alpha_mode"});
        return names;
    }();
    return title;
}

const std::vector<std::string> &events_title() {
    static const std::vector<std::string> title{"time_s", "text"};
    return title;
}

control::Tuning tuning_from_cells(const std::filesystem::path &file, const CsvLine &line,
                                  std::size_t first) {
    control::Tuning tuning;
    std::size_t cell = first;
    for (const control::Parameter &parameter : control::kParameters) {
        tuning.*parameter.value = csv_number(file, line, cell++);
    }
    const std::optional<control::MotionMap> map = control::motion_map_named(line.cells[cell]);
    if (!map) {
        refuse_cell(file, line, cell, "the name of a map");
    }
    const std::optional<control::AlphaMode> mode = control::alpha_mode_named(line.cells[++cell]);
    if (!mode) {
        refuse_cell(file, line, cell, "the name of a source of alpha");
    }
    tuning.map = *map;
    tuning.alpha_mode = *mode;
    return tuning;
}

} // namespace

std::filesystem::path name_of_device_file(std::size_t number) {
    return numbered_name("device.toml", number + 1);
}

std::string run_json(const RunFacts &facts, const std::filesystem::path &folder) {
    nlohmann::ordered_json document;
    document["format"] = kRunFormat;
    document["software"] = facts.software;
    document["started_utc"] = utc_text(facts.started);
    document["kept_utc"] = utc_text(facts.kept);
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
    facts.software = document["software"].text();
    facts.started = document["started_utc"].time();
    facts.kept = document["kept_utc"].time();
    facts.until_s = document["until_s"].number();
    facts.servo_hz = document["servo_hz"].number();
    facts.delay_periods = document["delay_periods"].number();
    for (const RunValue &device : document["devices"].list()) {
        facts.devices.push_back(device_from_json(device));
    }
    const RunValue scene = document["scene"];
    facts.scene = {scene["file"].text(), scene["sha256"].text(), scene["triangles"].count()};
    const RunValue slot = document["active_slot"];
    const auto *const active = std::ranges::find(kTuningSlotNames, slot.text());
    if (active == kTuningSlotNames.end()) {
        slot.refuse("A or B");
    }
    if (name_of(facts.slots.active()) != *active) {
        facts.slots.toggle();
    }
    for (const RunValue &record : document["records"].list()) {
        facts.records.push_back(record_from_json(record, facts.devices.size()));
    }
    for (const RunValue &picture : document["screenshots"].list()) {
        facts.screenshots.push_back(picture_from_json(picture));
    }
}

std::string journal_csv(const std::vector<TuningEvent> &journal) {
    std::string text = fmt::format("{}\n", fmt::join(journal_title(), ","));
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

std::vector<TuningEvent> read_journal_csv(std::string_view text,
                                          const std::filesystem::path &file) {
    std::vector<TuningEvent> journal;
    for (const CsvLine &line : csv_lines(text, file, journal_title())) {
        TuningEvent event{csv_number(file, line, 0), csv_number(file, line, 1), line.cells[2],
                          tuning_from_cells(file, line, 3)};
        if (event.time_s < event.began_s) {
            refuse_cell(file, line, 1, "no earlier than began_s");
        }
        if (!journal.empty() && event.time_s < journal.back().time_s) {
            refuse_cell(file, line, 1, "no earlier than in the line before");
        }
        journal.push_back(std::move(event));
    }
    return journal;
}

std::string events_csv(const std::vector<RunEvent> &events) {
    std::string text = fmt::format("{}\n", fmt::join(events_title(), ","));
    for (const RunEvent &event : events) {
        text += fmt::format("{},{}\n", csv_cell(event.time_s), csv_cell(event.text));
    }
    return text;
}

std::vector<RunEvent> read_events_csv(std::string_view text, const std::filesystem::path &file) {
    std::vector<RunEvent> events;
    for (const CsvLine &line : csv_lines(text, file, events_title())) {
        events.push_back({csv_number(file, line, 0), line.cells[1]});
    }
    return events;
}

} // namespace springdrive::session
