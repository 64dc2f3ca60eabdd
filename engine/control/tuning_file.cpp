#include "engine/control/tuning_file.h"

#include "base/one_line.h"
#include "base/strict_toml.h"
#include "engine/control/tuning.h"

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

/// In TOML's format of a floating-point number.
std::string digits(double value) {
    const std::string number = shortest_text(value);
    return number.find_first_of(".e") == std::string::npos ? number + ".0" : number;
}

/// A TOML string on one line.
std::string toml_string(std::string_view text) {
    std::string inside;
    for (const char c : text) {
        inside += c == '"' || c == '\\' ? std::string("\\") + c
                                        : std::string(1, c < ' ' && c >= 0 ? ' ' : c);
    }
    return '"' + inside + '"';
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
    out << "description = " << toml_string(file.description) << '\n';
    out << "map = " << toml_string(name_of(file.tuning.map)) << '\n';
    out << "alpha_mode = " << toml_string(name_of(file.tuning.alpha_mode)) << '\n';
    for (const Parameter &parameter : kParameters) {
        out << parameter.name << " = " << digits(file.tuning.*parameter.value) << '\n';
    }
    if (!file.margins) {
        return;
    }
    const TuningMargins &margins = *file.margins;
    out << "\n# How far it is from where it fails, one thing changed at a time.\n[margins]\n";
    out << "servo_hz = " << digits(margins.servo_hz) << '\n';
    out << "delay_periods = " << digits(margins.delay_periods) << '\n';
    out << "gain = " << digits(margins.gain) << '\n';
    out << "more_delay_periods = " << margins.more_delay_periods << '\n';
    out << "least_dR_Ohm = " << digits(margins.min_dR_Ohm) << '\n';
    out << "K_DC_Nm_per_rad = " << digits(margins.K_DC_Nm_per_rad) << '\n';
    out << "worst_hand = " << toml_string(margins.worst_hand) << '\n';
    out << "worst_eta = " << digits(margins.worst_eta) << '\n';
}

} // namespace springdrive::control
