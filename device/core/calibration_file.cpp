#include "device/core/calibration_file.h"

#include "base/input_error.h"
#include "device/core/motor/winding_guard.h"

#include <fmt/format.h>

#include <cmath>
#include <ctime>
#include <optional>
#include <sstream>

namespace springdrive::device {

namespace {

/// For noise, and products of tolerances.
constexpr double kBeyondTolerance = 0.005;

/// Shares of R, of its deviations: a better one than that nobody measures, and a worse one is none.
constexpr NumberRange kDeviation{1e-6, 0.05};

/// A ripple may be larger than the file's by its half: the harmonics share it differently.
constexpr double kLargerRipple = 1.5;

constexpr NumberRange kAir_C{-20.0, 60.0};
constexpr NumberRange kAirError_K{0.1, 20.0};

/// Years 1970 to 2105: a board has 32 bits for it.
constexpr std::int64_t kLatest_s = 0xffffffff;

std::optional<std::int64_t> seconds_of_utc(const std::string &text) {
    std::tm parts{};
    const char *const end = strptime(text.c_str(), "%Y-%m-%dT%H:%M:%SZ", &parts);
    if (end == nullptr) {
        return std::nullopt;
    }
    const std::int64_t seconds = timegm(&parts);
    const bool is_whole = seconds >= 0 && seconds <= kLatest_s && text_of_utc(seconds) == text;
    return is_whole ? std::optional(seconds) : std::nullopt;
}

/// As a basic string of TOML.
std::string quoted(const std::string &text) {
    std::string quoted = "\"";
    for (const char letter : text) {
        if (letter == '"' || letter == '\\') {
            quoted += '\\';
        }
        const bool is_printable = letter >= ' ' && letter != '\x7f';
        quoted += is_printable ? letter : '?';
    }
    return quoted + '"';
}

/// Whether a line begins a table, and whether that belongs to the calibration.
struct TableHeader {
    bool is_one = false;
    bool is_calibration = false;
};

TableHeader header_in(const std::string &line) {
    const std::size_t first = line.find_first_not_of(" \t");
    if (first == std::string::npos || line[first] != '[') {
        return {};
    }
    const std::size_t begin = line.find_first_not_of("[ \t", first);
    const std::size_t end = line.find_first_of(". \t]", begin);
    return {true, begin != std::string::npos && line.substr(begin, end - begin) == "calibration"};
}

std::string without_calibration(const std::string &device_text) {
    std::string kept;
    bool is_left_out = false;
    std::istringstream lines(device_text);
    for (std::string line; std::getline(lines, line);) {
        if (const TableHeader header = header_in(line); header.is_one) {
            is_left_out = header.is_calibration;
        }
        if (!is_left_out) {
            kept += line + '\n';
        }
    }
    while (kept.ends_with("\n\n")) {
        kept.pop_back();
    }
    return kept;
}

} // namespace

std::string text_of_utc(std::int64_t seconds_since_1970) {
    const auto time = static_cast<std::time_t>(seconds_since_1970);
    std::tm parts{};
    gmtime_r(&time, &parts);
    return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}Z", parts.tm_year + 1900,
                       parts.tm_mon + 1, parts.tm_mday, parts.tm_hour, parts.tm_min, parts.tm_sec);
}

std::array<CalibrationField, 12> calibration_fields(const DeviceDescription &device,
                                                    std::size_t motor, double air_error_K) {
    const MotorParameters &file = device.motor[motor];
    const double R = file.resistance_Ohm;
    const double share = device.resistance_tolerance(motor) +
                         file.resistance_rise_per_K * air_error_K + kBeyondTolerance;
    const double k_T = file.torque_constant_Nm_per_A;
    const double k_T_share = file.torque_constant_tolerance + kBeyondTolerance;
    const double ripple = R * (kLargerRipple * file.commutation_ripple + kBeyondTolerance);
    const double offset_A = 1.1 * device.current_sensing.max_offset_A + 1e-3;
    const NumberRange deviation{kDeviation.minimum * R, kDeviation.maximum * R};
    using Motor = MotorCalibration;
    return {{
        {"resistance_Ohm", &Motor::resistance_Ohm, {(1.0 - share) * R, (1.0 + share) * R}},
        {"resistance_deviation_Ohm", &Motor::resistance_deviation_Ohm, deviation},
        {"ripple_cos_Ohm", &Motor::ripple_cos_Ohm, {-ripple, ripple}},
        {"ripple_sin_Ohm", &Motor::ripple_sin_Ohm, {-ripple, ripple}},
        {"ripple_deviation_Ohm", &Motor::ripple_deviation_Ohm, deviation},
        {"ripple_cos_2_Ohm", &Motor::ripple_cos_2_Ohm, {-ripple, ripple}},
        {"ripple_sin_2_Ohm", &Motor::ripple_sin_2_Ohm, {-ripple, ripple}},
        {"ripple_2_deviation_Ohm", &Motor::ripple_2_deviation_Ohm, deviation},
        {"torque_constant_Nm_per_A",
         &Motor::torque_constant_Nm_per_A,
         {(1.0 - k_T_share) * k_T, (1.0 + k_T_share) * k_T}},
        {"torque_constant_deviation_Nm_per_A",
         &Motor::torque_constant_deviation_Nm_per_A,
         {kDeviation.minimum * k_T, kDeviation.maximum * k_T}},
        {"offset_A", &Motor::offset_A, {-offset_A, offset_A}},
        {"offset_deviation_A", &Motor::offset_deviation_A, {1e-9, 0.1}},
    }};
}

Calibration read_calibration(StrictTomlTable table, const DeviceDescription &device) {
    Calibration calibration;
    calibration.serial = table.text("serial");
    calibration.kind = table.text("kind");
    calibration.firmware = table.text("firmware");
    const std::optional<std::int64_t> made_at_s = seconds_of_utc(table.text("date"));
    if (!made_at_s) {
        table.refuse("date", "is no date like \"2026-11-25T05:10:22Z\"");
    }
    calibration.made_at_s = *made_at_s;
    calibration.air_C = table.number("air_C", kAir_C);
    calibration.air_error_K = table.number("air_error_K", kAirError_K);
    const int motors = table.tables("motor", 3, [&](int index, StrictTomlTable &motor) {
        const auto j = static_cast<std::size_t>(index);
        for (const CalibrationField &field :
             calibration_fields(device, j, calibration.air_error_K)) {
            calibration.motor[j].*field.value = motor.number(field.key, field.range);
        }
        motor.refuse_unknown_keys();
    });
    if (motors != 3) {
        table.refuse("motor", "is for one motor; it must appear three times, as "
                              "[[calibration.motor]]");
    }
    table.refuse_unknown_keys();
    return calibration;
}

std::string validate(const Calibration &calibration, const DeviceDescription &device) {
    const auto check = [](const std::string &name, double value, NumberRange range) {
        return unless_from_to(name, value, range.minimum, range.maximum);
    };
    std::string wrong = check("air_C", calibration.air_C, kAir_C);
    if (wrong.empty()) {
        wrong = check("air_error_K", calibration.air_error_K, kAirError_K);
    }
    for (std::size_t j = 0; j < 3; ++j) {
        for (const CalibrationField &field :
             calibration_fields(device, j, calibration.air_error_K)) {
            if (wrong.empty()) {
                wrong = check(fmt::format("motor {}: {}", j + 1, field.key),
                              calibration.motor[j].*field.value, field.range);
            }
        }
    }
    return wrong;
}

std::string with_calibration(const std::string &device_text, const Calibration &calibration) {
    std::string text = without_calibration(device_text);
    text += fmt::format("\n[calibration] # of one device, by springdrive device calibrate\n"
                        "serial = {}\nkind = {}\nfirmware = {}\ndate = \"{}\"\n"
                        "air_C = {:.6g}\nair_error_K = {:.6g}\n",
                        quoted(calibration.serial), quoted(calibration.kind),
                        quoted(calibration.firmware), text_of_utc(calibration.made_at_s),
                        calibration.air_C, calibration.air_error_K);
    const DeviceDescription any; // keys are the same for all
    for (std::size_t j = 0; j < 3; ++j) {
        text += "\n[[calibration.motor]]\n";
        for (const CalibrationField &field : calibration_fields(any, j, 0.0)) {
            text += fmt::format("{} = {:.9g}\n", field.key, calibration.motor[j].*field.value);
        }
    }
    return text;
}

void require_calibration_of(const DeviceDescription &device, const std::string &serial) {
    if (device.calibration && device.calibration->serial != serial) {
        throw InputError(fmt::format(
            "the device file's calibration is of the device '{}', but this is '{}'; use the file "
            "of this device, or calibrate it: springdrive device calibrate",
            device.calibration->serial, serial));
    }
}

} // namespace springdrive::device
