#include "device/core/device_file.h"

#include "base/degrees.h"
#include "base/input_error.h"
#include "base/strict_toml.h"
#include "device/core/motor/winding_heat.h"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <ctime>
#include <limits>
#include <optional>
#include <span>
#include <sstream>

namespace springdrive::device {

namespace {

// Of calibrations.

/// For noise, and products of tolerances.
constexpr double kBeyondTolerance = 0.005;

/// Shares of R, of its deviations: a better one than that nobody measures, and a worse one is none.
constexpr NumberRange kDeviation{1e-6, 0.05};

/// A ripple may be larger than the file's by its half: the harmonics share it differently.
constexpr double kLargerRipple = 1.5;

constexpr NumberRange kAir_C{-20.0, 60.0};
constexpr NumberRange kAirError_K{0.1, 20.0};

/// V_b near zero may be measured as a little less, and the largest as a little more.
constexpr double kBeyondBrush_V = 0.01;
constexpr NumberRange kBrushDeviation_V{1e-5, 0.1};
constexpr NumberRange kBrushCurrent_A{1e-3, 1.0};

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

// The ranges reject impossible values and wrong units (millimetres for metres, degrees for radians,
// g·cm² for kg·m²); every known device lies well within them.
MotorParameters read_motor(StrictTomlTable &table) {
    MotorParameters motor;
    motor.resistance_Ohm = table.number("resistance_Ohm", {0.01, 1000.0});
    motor.inductance_H = table.number("inductance_H", {1e-6, 0.1});
    motor.torque_constant_Nm_per_A = table.number("torque_constant_Nm_per_A", {1e-4, 10.0});
    motor.rotor_inertia_kg_m2 = table.number("rotor_inertia_kg_m2", {1e-9, 1e-2});
    motor.supply_V = table.number("supply_V", {0.1, 100.0});
    motor.peak_current_A = table.number("peak_current_A", {0.01, 100.0});
    motor.resistance_rise_per_K = table.number("resistance_rise_per_K", {0.0, 0.01});
    motor.commutation_ripple = table.number("commutation_ripple", {0.0, 0.5});
    motor.commutator_segments = table.integer("commutator_segments", 1, 1000);
    motor.thermal.winding_housing_K_per_W = table.number("winding_housing_K_per_W", {0.01, 1000.0});
    motor.thermal.housing_ambient_K_per_W = table.number("housing_ambient_K_per_W", {0.01, 1000.0});
    motor.thermal.winding_time_s = table.number("winding_time_s", {0.1, 1e4});
    motor.thermal.motor_time_s = table.number("motor_time_s", {1.0, 1e5});
    motor.thermal.max_winding_C = table.number("greatest_winding_C", {40.0, 300.0});
    // Not in older files, as records hold them.
    if (table.has("resistance_tolerance")) {
        motor.resistance_tolerance = table.number("resistance_tolerance", {0.0, 0.5});
    }
    if (table.has("torque_constant_tolerance")) {
        motor.torque_constant_tolerance = table.number("torque_constant_tolerance", {0.0, 0.5});
    }
    if (table.has("greatest_brush_voltage_V")) {
        motor.max_brush_voltage_V = table.number("greatest_brush_voltage_V", {0.0, 2.0});
    }
    if (table.has("torque_constant_fall_per_K")) {
        motor.torque_constant_fall_per_K = table.number("torque_constant_fall_per_K", {0.0, 0.005});
    }
    if (table.has("greatest_torque_ripple")) {
        motor.max_torque_ripple = table.number("greatest_torque_ripple", {0.0, 0.2});
    }
    table.refuse_unknown_keys();
    return motor;
}

CurrentSensing read_current_sensing(StrictTomlTable table) {
    CurrentSensing sensing;
    sensing.resolution_A = table.number("resolution_A", {0.0, 1.0});
    sensing.noise_A = table.number("noise_A", {0.0, 1.0});
    sensing.max_offset_A = table.number("greatest_offset_A", {0.0, 1.0});
    sensing.gain_tolerance = table.number("gain_tolerance", {0.0, 0.2});
    sensing.is_shared = table.integer("shared_with_amplifier", 0, 1) == 1;
    table.refuse_unknown_keys();
    return sensing;
}

PhantomGeometry read_geometry(StrictTomlTable linkage) {
    PhantomGeometry geometry;
    geometry.upper_arm_m = linkage.number("upper_arm_m", {0.01, 2.0});
    geometry.forearm_m = linkage.number("forearm_m", {0.01, 2.0});
    geometry.crank_m = linkage.number("crank_m", {0.001, 1.0});
    geometry.transmission_ratio = linkage.vector("transmission_ratio", {0.1, 1000.0});
    linkage.refuse_unknown_keys();
    return geometry;
}

/// What a link's inertia refers to.
enum class About : std::uint8_t { joint, centre };

LinkBody read_body(StrictTomlTable table, About about) {
    LinkBody body;
    body.mass_kg = table.number("mass_kg", {1e-4, 10.0});
    body.centre_m = table.number("centre_m", {-1.0, 1.0});
    body.inertia_kg_m2 = table.vector("inertia_kg_m2", {1e-10, 1.0});
    // About a joint the inertia is at least that of the point mass. (The triangle inequality of the
    // moments is not checked: published values violate it.)
    const double min_kg_m2 =
        about == About::joint ? body.mass_kg * body.centre_m * body.centre_m : 0.0;
    if (std::min(body.inertia_kg_m2[0], body.inertia_kg_m2[1]) < min_kg_m2) {
        table.refuse(
            "inertia_kg_m2",
            fmt::format("is too small for a mass at that distance from the joint; its first two "
                        "numbers must be at least mass_kg times centre_m squared, {:g}",
                        min_kg_m2));
    }
    table.refuse_unknown_keys();
    return body;
}

LinkageInertia read_inertia(StrictTomlTable table) {
    LinkageInertia inertia;
    inertia.base_kg_m2 = table.number("base_kg_m2", {1e-7, 1.0});
    inertia.upper_arm = read_body(table.table("upper_arm"), About::joint);
    inertia.crank = read_body(table.table("crank"), About::joint);
    inertia.rod = read_body(table.table("rod"), About::centre);
    inertia.forearm = read_body(table.table("forearm"), About::centre);
    inertia.tip_load_kg = table.number("tip_load_kg", {0.0, 5.0});
    table.refuse_unknown_keys();
    return inertia;
}

JointFriction read_friction(StrictTomlTable table) {
    JointFriction friction;
    friction.viscous_Nms_per_rad = table.number("viscous_Nms_per_rad", {0.0, 1.0});
    friction.coulomb_Nm = table.vector("coulomb_Nm", {0.0, 1.0});
    table.refuse_unknown_keys();
    return friction;
}

JointLimits read_joint_limits(StrictTomlTable table) {
    JointLimits limits;
    limits.min_rad = kRadiansPerDegree * table.vector("lowest_deg", {-180.0, 0.0});
    limits.max_rad = kRadiansPerDegree * table.vector("highest_deg", {0.0, 270.0});
    limits.min_q3_minus_q2_rad =
        kRadiansPerDegree * table.number("least_q3_minus_q2_deg", {-89.0, 0.0});
    limits.max_q3_minus_q2_rad =
        kRadiansPerDegree * table.number("greatest_q3_minus_q2_deg", {0.0, 89.0});
    table.refuse_unknown_keys();
    return limits;
}

WorkspaceEdge read_edge(StrictTomlTable table) {
    WorkspaceEdge edge;
    edge.margin_rad = kRadiansPerDegree * table.number("margin_deg", {0.0, 30.0});
    edge.stiffness_Nm_per_rad = table.number("stiffness_Nm_per_rad", {0.0, 100.0});
    edge.damping_Nms_per_rad = table.number("damping_Nms_per_rad", {0.0, 10.0});
    table.refuse_unknown_keys();
    return edge;
}

constexpr double kSecondsPerMillisecond = 1e-3;

DeviceLimits read_limits(StrictTomlTable table) {
    DeviceLimits limits;
    limits.tip_force_N = table.number("tip_force_N", {0.1, 100.0});
    limits.tip_speed_m_per_s = table.number("tip_speed_m_per_s", {0.01, 20.0});
    limits.beyond_stops_rad = kRadiansPerDegree * table.number("beyond_stops_deg", {0.1, 45.0});
    limits.generated_energy_J = table.number("generated_energy_J", {1e-4, 10.0});
    if (table.has("missed_deadlines")) { // older files: periods at 1 kHz
        if (table.has("late_ms") || table.has("stale_ms")) {
            table.refuse("missed_deadlines", "was replaced by late_ms; remove it");
        }
        limits.late_s = kSecondsPerMillisecond * table.integer("missed_deadlines", 1, 10'000);
        limits.stale_s = 5e-3;
    } else {
        limits.late_s = kSecondsPerMillisecond * table.number("late_ms", {0.1, 1e4});
        limits.stale_s = kSecondsPerMillisecond * table.number("stale_ms", {0.1, 1e4});
    }
    limits.window_silence_s = table.number("window_silence_s", {0.05, 60.0});
    table.refuse_unknown_keys();
    return limits;
}

StructuralCompliance read_structure(StrictTomlTable table) {
    StructuralCompliance structure;
    structure.stiffness_N_per_m = table.number("stiffness_N_per_m", {10.0, 1e7});
    structure.damping_Ns_per_m = table.number("damping_Ns_per_m", {0.0, 1e4});
    // Known of few devices.
    if (table.has("cable_share")) {
        structure.cable_share = table.number("cable_share", {0.0, 1.0});
    }
    if (table.has("cable_damping_ratio")) {
        structure.cable_damping_ratio = table.number("cable_damping_ratio", {0.0, 1.0});
    }
    table.refuse_unknown_keys();
    return structure;
}

AmplifierParameters read_amplifier(StrictTomlTable table,
                                   const std::array<MotorParameters, 3> &motors) {
    AmplifierParameters amplifier;
    // R̂ may exceed R by as much as a warm winding's R does, at most by the excess that the file
    // allows.
    const double excess_Ohm = table.number("greatest_excess_Ohm", {0.0, 100.0});
    double min_resistance_Ohm = std::numeric_limits<double>::infinity();
    for (const MotorParameters &motor : motors) {
        min_resistance_Ohm = std::min(min_resistance_Ohm, motor.resistance_Ohm);
    }
    amplifier.max_cancelled_Ohm =
        table.number("greatest_cancelled_Ohm", {0.0, min_resistance_Ohm + excess_Ohm});
    amplifier.current_bandwidth_hz = table.number("current_bandwidth_hz", {1.0, 1e6});
    table.refuse_unknown_keys();
    return amplifier;
}

std::span<const CalibrationField>
first_of(const std::array<CalibrationField, kCalibrationFields> &fields, bool has_brushes) {
    return std::span(fields).first(has_brushes ? kCalibrationFields : kFirstBrushField);
}

/// Whether any number of them is known.
bool has_brushes(const MotorCalibration &motor) {
    const auto fields = calibration_fields({}, 0, 0.0);
    return std::ranges::any_of(
        std::span(fields).subspan(kFirstBrushField),
        [&](const CalibrationField &field) { return motor.*field.value != 0.0; });
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
        const auto fields = calibration_fields(device, j, calibration.air_error_K);
        const bool has_brushes = motor.has(fields[kFirstBrushField].key); // not in older files
        for (const CalibrationField &field : first_of(fields, has_brushes)) {
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

DeviceDescription read_device(StrictTomlTable file) {
    DeviceDescription device;
    device.name = file.text("name");

    device.geometry = read_geometry(file.table("linkage"));
    device.inertia = read_inertia(file.table("inertia"));
    device.friction = read_friction(file.table("friction"));
    device.joint_limits = read_joint_limits(file.table("joint_limits"));
    device.structure = read_structure(file.table("structure"));

    const int motors = file.tables("motor", 3, [&device](int index, StrictTomlTable &table) {
        device.motor[static_cast<std::size_t>(index)] = read_motor(table);
    });
    if (motors == 1) {
        device.motor.fill(device.motor.front());
    }
    device.amplifier = read_amplifier(file.table("amplifier"), device.motor);

    if (file.has("current_sensing")) { // not in older files
        device.current_sensing = read_current_sensing(file.table("current_sensing"));
    }

    StrictTomlTable encoder = file.table("encoder");
    device.encoder_counts_per_turn = encoder.integer("counts_per_turn", 4, 100'000);
    encoder.refuse_unknown_keys();

    StrictTomlTable workspace = file.table("workspace");
    device.workspace.centre_m = workspace.vector("centre_m", {-2.0, 2.0});
    device.workspace.size_m = workspace.vector("size_m", {0.01, 2.0});
    if (!can_reach(device, device.workspace.centre_m)) {
        workspace.refuse("centre_m", "is out of reach; it must be a point that the tip can be at, "
                                     "within linkage and joint_limits");
    }
    workspace.refuse_unknown_keys();

    device.edge = read_edge(file.table("edge"));
    device.limits = read_limits(file.table("limits"));
    if (file.has("calibration")) {
        device.calibration = read_calibration(file.table("calibration"), device);
    }

    file.refuse_unknown_keys();
    return device;
}

} // namespace

DeviceDescription read_device_file(const std::filesystem::path &path) {
    return read_device(StrictTomlTable::read(path));
}

DeviceDescription read_device_text(const std::string &text, const std::filesystem::path &path) {
    return read_device(StrictTomlTable::parse(text, path));
}

std::string text_of_utc(std::int64_t seconds_since_1970) {
    const auto time = static_cast<std::time_t>(seconds_since_1970);
    std::tm parts{};
    gmtime_r(&time, &parts);
    return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}Z", parts.tm_year + 1900,
                       parts.tm_mon + 1, parts.tm_mday, parts.tm_hour, parts.tm_min, parts.tm_sec);
}

std::array<CalibrationField, kCalibrationFields>
calibration_fields(const DeviceDescription &device, std::size_t motor, double air_error_K) {
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
        {"brush_voltage_V",
         &Motor::brush_voltage_V,
         {-kBeyondBrush_V, file.max_brush_voltage_V + kBeyondBrush_V}},
        {"brush_deviation_V", &Motor::brush_deviation_V, kBrushDeviation_V},
        {"least_brush_current_A", &Motor::min_brush_current_A, kBrushCurrent_A},
        {"greatest_brush_current_A", &Motor::max_brush_current_A, kBrushCurrent_A},
    }};
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
        const auto fields = calibration_fields(device, j, calibration.air_error_K);
        for (const CalibrationField &field : first_of(fields, has_brushes(calibration.motor[j]))) {
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
        const auto fields = calibration_fields(any, j, 0.0);
        for (const CalibrationField &field : first_of(fields, has_brushes(calibration.motor[j]))) {
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
