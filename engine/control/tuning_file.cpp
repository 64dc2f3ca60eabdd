#include "engine/control/tuning_file.h"

#include "base/quoting.h"
#include "base/strict_toml.h"
#include "engine/control/tuning.h"

#include <algorithm>
#include <string>
#include <string_view>

namespace springdrive::control {

namespace {

/// The key of a delay in this file: `key`, or its name from when d was a whole number.
std::string_view delay_key(StrictTomlTable &table, std::string_view key, std::string_view before) {
    if (!table.has(before)) {
        return key;
    }
    if (table.has(key)) {
        table.refuse(before, "is the old name of " + std::string(key) + "; keep only one of them");
    }
    return before;
}

TuningMargins read_margins(StrictTomlTable table) {
    constexpr double kMaxRate_hz = 1e6;
    constexpr int kLongest_periods = 100;
    TuningMargins margins;
    margins.servo_hz = table.number("servo_hz", {1.0, kMaxRate_hz});
    margins.delay_periods =
        table.number(delay_key(table, "delay_periods", "delay_samples"), {0.0, kLongest_periods});
    margins.gain = table.number("gain", {1.0});
    margins.more_delay_periods = table.integer(
        delay_key(table, "more_delay_periods", "more_delay_samples"), 0, kLongest_periods);
    margins.min_dR_Ohm = table.number("least_dR_Ohm", {0.0});
    margins.K_DC_Nm_per_rad = table.number("K_DC_Nm_per_rad", {0.0});
    margins.worst_hand = table.text("worst_hand");
    margins.worst_eta = table.number("worst_eta", {0.0, 1.0});
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
    const TuningMargins &margins = *file.margins;
    out << "\n# How far it is from where it fails, one thing changed at a time.\n[margins]\n";
    out << "servo_hz = " << toml_number(margins.servo_hz) << '\n';
    out << "delay_periods = " << toml_number(margins.delay_periods) << '\n';
    out << "gain = " << toml_number(margins.gain) << '\n';
    out << "more_delay_periods = " << margins.more_delay_periods << '\n';
    out << "least_dR_Ohm = " << toml_number(margins.min_dR_Ohm) << '\n';
    out << "K_DC_Nm_per_rad = " << toml_number(margins.K_DC_Nm_per_rad) << '\n';
    out << "worst_hand = " << toml_string(margins.worst_hand) << '\n';
    out << "worst_eta = " << toml_number(margins.worst_eta) << '\n';
}

} // namespace springdrive::control
