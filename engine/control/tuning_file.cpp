#include "engine/control/tuning_file.h"

#include "base/field_toml.h"
#include "engine/control/tuning.h"

#include <algorithm>
#include <limits>
#include <string>
#include <string_view>

namespace springdrive::control {

namespace {

constexpr double kMaxRate_hz = 1e6;
constexpr double kMax_periods = 100.0;
constexpr double kAny = std::numeric_limits<double>::max();

constexpr auto kMarginFields = std::to_array<Field<TuningMargins>>({
    {"servo_hz", &TuningMargins::servo_hz, "", 1.0, kMaxRate_hz, "Hz", kRequired},
    {"delay_periods", &TuningMargins::delay_periods, "", 0.0, kMax_periods, "", kRequired},
    {"gain", &TuningMargins::gain, "", 1.0, kAny, "", kRequired},
    {"more_delay_periods", &TuningMargins::more_delay_periods, "", 0.0, kMax_periods, "",
     kRequired},
    {"least_dR_Ohm", &TuningMargins::min_dR_Ohm, "", 0.0, kAny, "Ω", kRequired},
    {"K_DC_Nm_per_rad", &TuningMargins::K_DC_Nm_per_rad, "", 0.0, kAny, "N·m/rad", kRequired},
    {"worst_hand", &TuningMargins::worst_hand, "", kRequired},
    {"worst_eta", &TuningMargins::worst_eta, "", 0.0, 1.0, "", kRequired},
});

TuningMargins read_margins(StrictTomlTable table) {
    auto fields = kMarginFields;
    for (auto &field : fields) { // the names from when d was a whole number
        const std::string_view before = field.name == "delay_periods"        ? "delay_samples"
                                        : field.name == "more_delay_periods" ? "more_delay_samples"
                                                                             : field.name;
        if (before != field.name && table.has(before)) {
            if (table.has(field.name)) {
                table.refuse(before, "is the old name of " + std::string(field.name) +
                                         "; keep only one of them");
            }
            field.name = before;
        }
    }
    TuningMargins margins;
    read(table, fields, margins);
    table.refuse_unknown_keys();
    return margins;
}

} // namespace

TuningFile read_whole_tuning_file(const std::filesystem::path &path) {
    StrictTomlTable table = StrictTomlTable::read(path);
    TuningFile file;
    file.description = table.text("description");
    for (const Parameter &parameter : kParameters) {
        file.tuning.*parameter.value =
            table.number(parameter.name, {parameter.minimum, parameter.maximum});
    }
    file.tuning.map = static_cast<MotionMap>(table.choice("map", kMotionMapNames));
    file.tuning.alpha_mode = static_cast<AlphaMode>(table.choice("alpha_mode", kAlphaModeNames));
    if (table.has("margins")) {
        file.margins = read_margins(table.table("margins"));
    }
    table.refuse_unknown_keys();
    return file;
}

Tuning read_tuning_file(const std::filesystem::path &path) {
    return read_whole_tuning_file(path).tuning;
}

void write_tuning_file(std::ostream &out, const TuningFile &file) {
    std::string description = file.description; // is shown on one line
    std::ranges::replace_if(
        description, [](char c) { return c >= 0 && c < ' '; }, ' ');
    out << "description = " << toml_string(description) << '\n';
    out << "map = " << toml_string(name_of(file.tuning.map)) << '\n';
    out << "alpha_mode = " << toml_string(name_of(file.tuning.alpha_mode)) << '\n';
    for (const Parameter &parameter : kParameters) {
        out << parameter.name << " = " << toml_number(file.tuning.*parameter.value) << '\n';
    }
    if (!file.margins) {
        return;
    }
    out << "\n# How far it is from where it fails, one thing changed at a time.\n[margins]\n";
    write(out, kMarginFields, *file.margins);
}

} // namespace springdrive::control
