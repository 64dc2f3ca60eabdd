#include "engine/study/export/trial_table.h"

#include "base/one_line.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace springdrive::study {

namespace {

template <typename Value> Cell cell_of(const Value &value) { return value; }
/// As text, so that an infinite number is written: "inf".
Cell cell_of(double number) {
    return std::isnan(number) ? Cell() : Cell::like_number(shortest_text(number));
}
Cell cell_of(const TrialPlace &place) {
    return fmt::format("{}-{}-{}", place.block, place.position, place.attempt);
}
template <typename Value> Cell cell_of(const std::optional<Value> &value) {
    return value ? cell_of(*value) : Cell();
}

std::string joined(const std::vector<std::string> &texts) {
    std::string all;
    for (const std::string &text : texts) {
        all += (all.empty() ? "" : "; ") + text;
    }
    return all;
}

std::string safety_text(const Trial &trial) {
    std::vector<std::string> texts;
    for (const SafetyEvent &event : trial.safety_events) {
        texts.push_back(event.text);
    }
    return joined(texts);
}

constexpr std::array<std::string_view, std::variant_size_v<Response>> kResponseKinds{
    "none", "chosen", "yes_no", "adjusted"};

Cell cell_of(const Response &response) {
    if (const auto *const chosen = std::get_if<Chosen>(&response)) {
        return cell_of(chosen->alternative);
    }
    if (const auto *const answer = std::get_if<YesNo>(&response)) {
        return cell_of(answer->yes);
    }
    const auto *const adjusted = std::get_if<Adjusted>(&response);
    return adjusted != nullptr ? cell_of(adjusted->level) : Cell();
}

/// Columns are added one after the other.
class Columns {
public:
    /// @param value  of a TrialInStudy
    template <typename Value>
    TrialColumn &add(std::string name, std::string description, Value &&value) {
        columns.push_back(
            {{.name = std::move(name), .meaning = std::move(description)},
             [value](const TrialInStudy &row) -> Cell { return cell_of(value(row)); }});
        return columns.back();
    }

    std::vector<TrialColumn> columns;
};

using Row = const TrialInStudy &;

void add_whose_and_where(Columns &to) {
    to.add("participant", "code of the participant", [](Row row) { return row.trial.participant; });
    to.add("participant_number", "number of the participant, for counterbalancing",
           [](Row row) { return row.participant.number; });
    to.add("session", "number of the session in the study", [](Row row) { return row.session.id; });
    to.add("device_kind", "what the session ran on",
           [](Row row) { return name_of(row.session.device); })
        .levels = {{"simulated", "no device and no person"},
                   {"emulated", "a simulated device behind an emulated board; no person"},
                   {"usb", "a device on USB"}};
    to.add("device_serial", "serial number of the device",
           [](Row row) { return row.session.device_serial; });
    to.add("block", "block, from 1", [](Row row) { return row.trial.place.block; });
    to.add("position", "position in the block, from 1",
           [](Row row) { return row.trial.place.position; });
    to.add("attempt", "1, or more if the position was repeated",
           [](Row row) { return row.trial.place.attempt; });
}

void add_stimulus_and_response(Columns &to) {
    to.add("condition", "name of the condition in the protocol",
           [](Row row) { return row.trial.condition; });
    to.add("track", "track of the method, such as one of several staircases",
           [](Row row) { return row.trial.track; });
    to.add("is_practice", "1 for a practice trial", [](Row row) { return row.trial.is_practice; });
    to.add("is_catch", "1 for a catch trial", [](Row row) { return row.trial.is_catch; });
    to.add("is_presented_again", "1 if the method did not count it and presents its level again",
           [](Row row) { return row.trial.is_presented_again; });
    to.add("counts", "1 for the analysis: no practice, no catch trial, no mark",
           [](Row row) { return counts(row.trial); });
    to.add("seed", "key of everything random in the trial", [](Row row) { return row.trial.seed; });
    to.add("level_name", "the variable under test, with its unit",
           [](Row row) { return row.trial.level_name; });
    to.add("level", "its value", [](Row row) { return row.trial.level; });
    to.add("target", "the right alternative, from 1; or 1 yes, 0 no",
           [](Row row) { return row.trial.target; });
    to.add("response_kind", "kind of the response",
           [](Row row) { return kResponseKinds[row.trial.response.index()]; })
        .levels = {{"none", "none was given"},
                   {"chosen", "an alternative, from 1"},
                   {"yes_no", "1 yes, 0 no"},
                   {"adjusted", "a level, in the unit of level_name"}};
    to.add("response", "the response, see response_kind",
           [](Row row) { return cell_of(row.trial.response); });
    to.add("is_correct", "1 for a right response", [](Row row) { return row.trial.is_correct; });
    to.add("response_time_s", "from the end of the last presentation to the response", [](Row row) {
          return row.trial.response_time_s;
      }).unit = "s";
}

void add_circumstances(Columns &to) {
    to.add("at_utc", "when the trial ended, ISO 8601, UTC",
           [](Row row) { return utc_text(row.trial.at); });
    to.add("software", "version of the program", [](Row row) { return row.trial.software; });
    to.add("missed_deadlines", "servo ticks that were late",
           [](Row row) { return row.trial.missed_deadlines; });
    to.add("safety_events", "trips of safety monitors",
           [](Row row) { return safety_text(row.trial); });
    to.add("marks", "why the trial does not count",
           [](Row row) { return joined(row.trial.marks); });
    to.add("repetition_of", "block-position-attempt of the trial that it repeats",
           [](Row row) { return row.trial.repetition_of; });
    to.add("repeated_by", "block-position-attempt of the trial that repeats it",
           [](Row row) { return row.trial.repeated_by; });
    to.add("record", "file of the servo record, relative to the study's folder", [](Row row) {
        return row.trial.record ? Cell(row.trial.record->path.string()) : Cell();
    });
    to.add("record_sha256", "SHA-256 of that file",
           [](Row row) { return row.trial.record ? Cell(row.trial.record->sha256) : Cell(); });
}

/// Names in the order of their first appearance.
void note_name(std::vector<std::string> &names, const std::string &name) {
    if (std::ranges::find(names, name) == names.end()) {
        names.push_back(name);
    }
}

/// The value of that name, if it is there.
template <typename Named>
const Named *named(const std::vector<Named> &values, const std::string &name) {
    const auto found = std::ranges::find(values, name, &Named::name);
    return found == values.end() ? nullptr : &*found;
}

const Presentation *presentation(Row row, std::size_t number) {
    return number < row.trial.presentations.size() ? &row.trial.presentations[number] : nullptr;
}

void add_presentation(Columns &to, const StudyContents &contents, std::size_t i) {
    const std::string prefix = fmt::format("presentation{}_", i + 1);
    const std::string which = fmt::format(" of presentation {}", i + 1);
    using Time = std::optional<double> Presentation::*;
    const auto add_time = [&](const char *name, const char *description, Time time) {
        to.add(prefix + name, description + which + ", servo's clock", [i, time](Row row) {
              const Presentation *const one = presentation(row, i);
              return one != nullptr ? one->*time : std::nullopt;
          }).unit = "s";
    };
    add_time("start_s", "start", &Presentation::start_s);
    add_time("end_s", "end", &Presentation::end_s);
    std::vector<std::string> names;
    for (const Trial &trial : contents.trials) {
        if (i < trial.presentations.size()) {
            for (const StimulusValue &value : trial.presentations[i].values) {
                note_name(names, value.name);
            }
        }
    }
    using Number = std::optional<double> StimulusValue::*;
    const auto add_value = [&](const std::string &name, const std::string &what, Number number) {
        to.add(prefix + name + "_" + what, name + which + ", " + what, [i, name, number](Row row) {
            const Presentation *const one = presentation(row, i);
            const StimulusValue *const value = one != nullptr ? named(one->values, name) : nullptr;
            return value != nullptr ? value->*number : std::nullopt;
        });
    };
    for (const std::string &name : names) {
        add_value(name, "intended", &StimulusValue::intended);
        add_value(name, "delivered", &StimulusValue::delivered);
    }
}

void add_own_of_study(Columns &to, const StudyContents &contents) {
    std::size_t presentations = 0;
    std::size_t windings = 0;
    std::vector<std::string> settings;
    for (const Trial &trial : contents.trials) {
        presentations = std::max(presentations, trial.presentations.size());
        windings = std::max(windings, trial.windings_degC.size());
        for (const Setting &setting : trial.tuning) {
            note_name(settings, setting.name);
        }
    }
    for (std::size_t i = 0; i < presentations; ++i) {
        add_presentation(to, contents, i);
    }
    for (std::size_t i = 0; i < windings; ++i) {
        to.add(fmt::format("winding{}_degC", i + 1),
               fmt::format("temperature of the winding of motor {}, at the end", i + 1),
               [i](Row row) {
                   return i < row.trial.windings_degC.size() ? row.trial.windings_degC[i]
                                                             : std::nullopt;
               })
            .unit = "degC";
    }
    for (const std::string &name : settings) {
        to.add("tuning_" + name, name + " of the tuning in force", [name](Row row) {
            const Setting *const setting = named(row.trial.tuning, name);
            return setting == nullptr ? Cell()
                                      : std::visit([](const auto &value) { return cell_of(value); },
                                                   setting->value);
        });
    }
}

} // namespace

std::vector<TrialColumn> trial_columns(const StudyContents &contents) {
    Columns all;
    add_whose_and_where(all);
    add_stimulus_and_response(all);
    add_circumstances(all);
    add_own_of_study(all, contents);
    return std::move(all.columns);
}

std::vector<TrialInStudy> trials_in_study(const StudyContents &contents,
                                          const std::vector<DeviceKind> &devices) {
    std::vector<TrialInStudy> trials;
    for (const Trial &trial : contents.trials) {
        const Session &session = session_of(contents, trial.session);
        if (std::ranges::find(devices, session.device) != devices.end()) {
            trials.push_back({trial, session, participant_of(contents, trial.participant)});
        }
    }
    return trials;
}

Table table_of(const std::vector<TrialColumn> &columns, const std::vector<TrialInStudy> &trials) {
    Table table{.columns = {columns.begin(), columns.end()}};
    for (const TrialInStudy &trial : trials) {
        std::vector<Cell> &row = table.rows.emplace_back();
        for (const TrialColumn &column : columns) {
            row.push_back(column.cell(trial));
        }
    }
    return table;
}

} // namespace springdrive::study
