// Covers device/core/device_file.cpp and, through it, base/strict_toml.cpp.
#include "device/core/device_file.h"

#include "base/input_error.h"
#include "tests/support/devices.h"
#include "tests/support/files.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <numbers>
#include <string>
#include <vector>

namespace springdrive::device {
namespace {

std::string good_text() {
    return testing::contents_of(testing::assets() / "devices/phantom_1_0.toml");
}

/// The error message for the valid file with its first `from` replaced by `to`.
std::string error(const std::string &from, const std::string &to) {
    std::string text = good_text();
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    const std::filesystem::path file = testing::fresh_folder("device_file") / "bad.toml";
    std::ofstream(file) << text;
    try {
        static_cast<void>(read_device_file(file));
    } catch (const InputError &error) {
        EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
        return error.what();
    }
    return "";
}

void expect_all(const std::string &message, std::initializer_list<const char *> parts) {
    for (const char *part : parts) {
        EXPECT_NE(message.find(part), std::string::npos) << part << " in: " << message;
    }
}

TEST(DeviceFile, HoldsTheDataSheet) {
    const DeviceDescription device = testing::phantom_1_0();
    EXPECT_EQ(device.geometry.upper_arm_m, 0.1397);
    EXPECT_EQ(device.geometry.transmission_ratio, Vector3(13.3, 11.2, 11.2));
    EXPECT_EQ(device.motor[2].inductance_H, 0.238e-3);
    EXPECT_EQ(device.motor[2].torque_constant_fall_per_K, 0.001);
    EXPECT_EQ(device.motor[2].max_torque_ripple, 0.02);
    EXPECT_EQ(device.encoder_counts_per_turn, 4096);
    EXPECT_DOUBLE_EQ(device.rad_per_count(), std::numbers::pi / 2048.0);
    EXPECT_EQ(testing::phantom_premium_1_5().geometry.forearm_m, 0.170);
}

TEST(DeviceFile, ThreeMotorsMayDiffer) {
    std::string text = good_text();
    const std::size_t first = text.find("[motor]");
    const std::size_t last = text.find("[amplifier]");
    std::string motor = text.substr(first, last - first);
    motor.replace(0, 7, "[[motor]]");
    std::string second = motor;
    second.replace(second.find("2.18"), 4, "3.25");
    text.replace(first, last - first, motor + second + motor);
    const std::filesystem::path file = testing::fresh_folder("device_file") / "three.toml";
    std::ofstream(file) << text;
    const DeviceDescription device = read_device_file(file);
    EXPECT_EQ(device.motor[0].resistance_Ohm, 2.18);
    EXPECT_EQ(device.motor[1].resistance_Ohm, 3.25);
    EXPECT_EQ(device.motor[2].resistance_Ohm, 2.18);
}

TEST(DeviceFile, MayTellWhereTheStructureYields) {
    EXPECT_FALSE(testing::phantom_1_0().structure.cable_share);
    const double assumed_ratio = StructuralCompliance{}.cable_damping_ratio;
    EXPECT_EQ(testing::phantom_1_0().structure.cable_damping_ratio, assumed_ratio);
    const std::string before = "damping_Ns_per_m = 1.0";
    const auto with = [&](const std::string &lines) {
        std::string text = good_text();
        text.insert(text.find(before), lines);
        return read_device_text(text, "device.toml").structure;
    };
    for (const double end : {0.0, 1.0}) {
        EXPECT_EQ(with(fmt::format("cable_share = {}\n", end)).cable_share, end);
        EXPECT_EQ(with(fmt::format("cable_damping_ratio = {}\n", end)).cable_damping_ratio, end);
    }
    for (const char *outside : {"-0.001", "1.001", "nan"}) {
        for (const char *key : {"cable_share", "cable_damping_ratio"}) {
            expect_all(error(before, fmt::format("{} = {}\n", key, outside) + before),
                       {key, "structure", "from"});
        }
    }
}

TEST(DeviceFile, RejectsInvalidValuesByNameLineAndRange) {
    expect_all(error("0.238e-3", "-1e-3"), {":56:", "motor.inductance_H", "-0.001", "from"});
    expect_all(error("0.238e-3", "nan"), {"motor.inductance_H", "from"});
    expect_all(error("0.238e-3", "inf"), {"motor.inductance_H", "from"});
    expect_all(error("0.238e-3", "\"much\""), {"motor.inductance_H", "much"});
    expect_all(error("[13.3, 11.2, 11.2]", "[13.3, 0, 11.2]"),
               {"linkage.transmission_ratio", "three numbers"});
    expect_all(error("[13.3, 11.2, 11.2]", "[13.3, 11.2]"), {"three numbers"});
    expect_all(error("4096", "4096.5"), {"encoder.counts_per_turn", "whole number"});
    expect_all(error("resistance_Ohm = 2.18", ""), {"motor.resistance_Ohm", "missing"});
    expect_all(error("resistance_Ohm", "resistence_Ohm"), {"missing"});
    expect_all(error("supply_V", "colour = 1\nsupply_V"), {"motor.colour", "not known"});
    expect_all(error("[0.0, 0.030, -0.015]", "[0.0, 1.0, 0.0]"),
               {"workspace.centre_m", "out of reach"});
    expect_all(error("highest_deg = [90.0, 119.0,", "highest_deg = [90.0, 2.0,"),
               {"workspace.centre_m", "joint_limits"});
    expect_all(error("centre_m = -0.0239", "centre_m = -0.239"),
               {"inertia.upper_arm.inertia_kg_m2", "at least", "0.0134748"}); // 0.2359 · 0.239²
    expect_all(error("centre_m = -0.0433", "centre_m = -0.433"),
               {"inertia.crank.inertia_kg_m2", "at least", "0.0357354"}); // 0.1906 · 0.433²
    expect_all(error("[limits]", "[limit]"), {"limits", "missing"});
    expect_all(error("mass_kg = 0.0166", "mass_kg = -0.0166"),
               {"inertia.forearm.mass_kg", "-0.0166", "from"});
    expect_all(error("base_kg_m2 = 5.01e-4", "base_kg_m2 = nan"), {"inertia.base_kg_m2", "from"});
    expect_all(error("[0.270e-4, 0.270e-4,", "[-0.270e-4, 0.270e-4,"),
               {"inertia.forearm.inertia_kg_m2"});
    expect_all(error("centre_m = -0.0239", "centre_mm = -23.9"),
               {"inertia.upper_arm.centre_m", "missing"});
    expect_all(error("coulomb_Nm = [0.0056,", "coulomb_Nm = [-0.0056,"), {"friction.coulomb_Nm"});
    expect_all(error("least_q3_minus_q2_deg = -65.0", "least_q3_minus_q2_deg = -95.0"),
               {"joint_limits.least_q3_minus_q2_deg", "-95", "-89"});
    expect_all(error("winding_time_s = 12.0", "winding_time_s = 0"),
               {"motor.winding_time_s", "from"});
    expect_all(error("name = ", "name : "), {":2:", "not valid TOML"});
    expect_all(error("0.1397 ", "139.7 "), {"linkage.upper_arm_m", "139.7"}); // millimetres
}

TEST(DeviceFile, RejectsAnAmplifierThatCancelsTooMuch) {
    // 2.18 Ω and an excess of 0.63 Ω make 2.81 Ω.
    EXPECT_EQ(error("greatest_cancelled_Ohm = 2.8 ", "greatest_cancelled_Ohm = 2.809 "), "");
    expect_all(error("greatest_cancelled_Ohm = 2.8 ", "greatest_cancelled_Ohm = 2.811 "),
               {"amplifier.greatest_cancelled_Ohm", "2.811", "from 0 to 2.81"});
    expect_all(error("greatest_excess_Ohm = 0.63", "greatest_excess_Ohm = -1"),
               {"amplifier.greatest_excess_Ohm", "from"});
}

struct Range {
    const char *key;
    const char *value; ///< as written in the file
    std::vector<const char *> allowed;
    std::vector<const char *> refused;
};

/// Both ends of a range are accepted; values beyond it and a missing key are rejected.
void expect_range(const std::string &table, const Range &range) {
    const std::string line = std::string(range.key) + " = " + range.value;
    for (const char *value : range.allowed) {
        EXPECT_EQ(error(line, std::string(range.key) + " = " + value), "") << value;
    }
    const std::string name = table + "." + range.key;
    for (const char *value : range.refused) {
        expect_all(error(line, std::string(range.key) + " = " + value), {name.c_str()});
    }
    for (const char *value : {"nan", "inf", "\"much\"", "[1.0]"}) {
        expect_all(error(line, std::string(range.key) + " = " + value), {name.c_str()});
    }
    expect_all(error(line, ""), {name.c_str(), "missing"});
    expect_all(error(line, line + "\n" + range.key + "_too = 1"), {name.c_str(), "not known"});
}

TEST(DeviceFile, HoldsTheEdgeAndTheLimits) {
    constexpr double kDegree = 3.141592653589793 / 180.0;
    for (const DeviceDescription &device :
         {testing::phantom_1_0(), testing::phantom_premium_1_5()}) {
        EXPECT_NEAR(device.edge.margin_rad, 5.0 * kDegree, 1e-15) << device.name;
        EXPECT_GT(device.edge.stiffness_Nm_per_rad, 0.0);
        EXPECT_GT(device.edge.damping_Nms_per_rad, 0.0);
        EXPECT_EQ(device.limits.tip_force_N, 8.5);
        EXPECT_GT(device.limits.window_silence_s, 0.0);
    }
    const DeviceDescription device = testing::phantom_1_0();
    EXPECT_EQ(device.edge.stiffness_Nm_per_rad, 4.0);
    EXPECT_EQ(device.edge.damping_Nms_per_rad, 0.08);
    EXPECT_EQ(device.limits.tip_speed_m_per_s, 2.0);
    EXPECT_NEAR(device.limits.beyond_stops_rad, 3.0 * kDegree, 1e-15);
    EXPECT_EQ(device.limits.generated_energy_J, 0.03);
    EXPECT_DOUBLE_EQ(device.limits.late_s, 0.05);
    EXPECT_DOUBLE_EQ(device.limits.stale_s, 0.005);
    EXPECT_EQ(device.limits.window_silence_s, 2.0);
}

TEST(DeviceFile, RejectsAnInvalidEdge) {
    expect_range("edge", {"margin_deg", "5.0", {"0.0", "30.0"}, {"-0.1", "30.1"}});
    expect_range("edge", {"stiffness_Nm_per_rad", "4.0", {"0.0", "100.0"}, {"-0.1", "100.1"}});
    expect_range("edge", {"damping_Nms_per_rad", "0.08", {"0.0", "10.0"}, {"-0.01", "10.1"}});
    expect_all(error("[edge]", "[edges]"), {"edge", "missing"});
}

TEST(DeviceFile, RejectsInvalidLimits) {
    expect_range("limits", {"tip_force_N", "8.5", {"0.1", "100.0"}, {"0.09", "100.1", "-8.5"}});
    expect_range("limits", {"tip_speed_m_per_s", "2.0", {"0.01", "20.0"}, {"0.0", "20.1"}});
    expect_range("limits", {"beyond_stops_deg", "3.0", {"0.1", "45.0"}, {"0.09", "45.1"}});
    expect_range("limits", {"generated_energy_J", "0.03", {"1e-4", "10.0"}, {"9e-5", "10.1"}});
    expect_range("limits",
                 {"late_ms", "50.0", {"0.1", "10000.0"}, {"0.0", "10001.0", "-1.0", "nan"}});
    expect_range("limits",
                 {"stale_ms", "5.0", {"0.1", "10000.0"}, {"0.0", "10001.0", "-1.0", "nan"}});
    expect_range("limits", {"window_silence_s", "2.0", {"0.05", "60.0"}, {"0.04", "60.1"}});
}

TEST(DeviceFile, ReadsTheLimitsOfOlderFiles) {
    std::string text = good_text();
    const std::size_t late = text.find("late_ms");
    const std::size_t silence = text.find("window_silence_s");
    const std::string both = text.substr(late, silence - late);
    text.replace(late, silence - late, "missed_deadlines = 40\n");
    const DeviceDescription device = read_device_text(text, "older.toml");
    EXPECT_DOUBLE_EQ(device.limits.late_s, 0.04); // at 1 kHz
    EXPECT_DOUBLE_EQ(device.limits.stale_s, 0.005);
    text.insert(late, both);
    EXPECT_THROW(static_cast<void>(read_device_text(text, "both.toml")), InputError);
}

TEST(DeviceFile, RejectsAMissingFile) {
    EXPECT_THROW(static_cast<void>(read_device_file("no such file.toml")), InputError);
    EXPECT_THROW(static_cast<void>(read_device_file(testing::assets())), InputError);
}

/// With numbers of which no two are the same.
Calibration possible() {
    Calibration calibration{"board-7", "USB", "emulated 1.2.3", 1'764'047'422, 21.5, 2.0, {}};
    const DeviceDescription kind = testing::phantom_1_0();
    double share = 0.3;
    for (std::size_t j = 0; j < 3; ++j) {
        for (const CalibrationField &field : calibration_fields(kind, j, calibration.air_error_K)) {
            share += 0.01;
            calibration.motor[j].*field.value =
                field.range.minimum + share * (field.range.maximum - field.range.minimum);
        }
    }
    return calibration;
}

/// The error for a device file with this calibration, in which `from` is replaced.
std::string error(const Calibration &calibration, const std::string &from = "",
                  const std::string &to = "") {
    std::string text = with_calibration(good_text(), calibration);
    const std::size_t at = text.rfind(from);
    EXPECT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    return error_text_of([&] { static_cast<void>(read_device_text(text, "mine.toml")); });
}

void expect_same(const Calibration &one, const Calibration &other, double share) {
    EXPECT_EQ(one.serial, other.serial);
    EXPECT_EQ(one.kind, other.kind);
    EXPECT_EQ(one.firmware, other.firmware);
    EXPECT_EQ(one.made_at_s, other.made_at_s);
    EXPECT_NEAR(one.air_C, other.air_C, share);
    EXPECT_NEAR(one.air_error_K, other.air_error_K, share);
    for (std::size_t j = 0; j < 3; ++j) {
        for (const CalibrationField &field : calibration_fields({}, j, 0.0)) {
            const double value = one.motor[j].*field.value;
            EXPECT_NEAR(value, other.motor[j].*field.value, share * std::abs(value)) << field.key;
        }
    }
}

TEST(CalibrationFile, IsReadAsItWasWritten) {
    const std::string text = with_calibration(good_text(), possible());
    EXPECT_EQ(text.find(good_text()), 0U);
    const DeviceDescription read = read_device_text(text, "mine.toml");
    ASSERT_TRUE(read.calibration);
    expect_same(possible(), *read.calibration, 1e-8); // nine digits
    EXPECT_NE(text.find("date = \"2025-11-25T05:10:22Z\""), std::string::npos) << text;
    EXPECT_FALSE(read_device_text(good_text(), "kind.toml").calibration);
}

// Those of before know nothing of brushes; of a part of it, nothing can be made.
TEST(CalibrationFile, HasAllOfTheBrushesOrNone) {
    Calibration calibration = possible();
    for (MotorCalibration &motor : calibration.motor) {
        motor.brush_voltage_V = motor.brush_deviation_V = 0.0;
        motor.min_brush_current_A = motor.max_brush_current_A = 0.0;
    }
    const std::string text = with_calibration(good_text(), calibration);
    EXPECT_EQ(text.find("brush_deviation_V"), std::string::npos) << text;
    const DeviceDescription read = read_device_text(text, "before.toml");
    ASSERT_TRUE(read.calibration);
    expect_same(calibration, *read.calibration, 1e-8);
    EXPECT_EQ(validate(calibration, read), "");

    for (double MotorCalibration::*const one :
         {&MotorCalibration::brush_deviation_V, &MotorCalibration::min_brush_current_A,
          &MotorCalibration::max_brush_current_A}) {
        Calibration partly = possible();
        partly.motor[1].*one = 0.0;
        EXPECT_NE(validate(partly, read), "");
        EXPECT_NE(error(partly), "");
    }
    EXPECT_NE(error(possible(), "brush_deviation_V = ", "# "), "");
    EXPECT_NE(error(possible(), "brush_voltage_V = ", "# "), "");
}

TEST(CalibrationFile, ReplacesTheOneBefore) {
    Calibration before = possible();
    before.serial = "another \"one\" \\ [calibration]";
    before.made_at_s = 0;
    const std::string once = with_calibration(good_text(), before);
    EXPECT_EQ(read_device_text(once, "mine.toml").calibration->serial, before.serial);
    EXPECT_EQ(text_of_utc(0), "1970-01-01T00:00:00Z");
    EXPECT_EQ(with_calibration(once, possible()), with_calibration(good_text(), possible()));

    // Also in the middle of a file: what follows stays.
    const std::size_t end = good_text().find("[limits]");
    const std::string middle =
        with_calibration(good_text().substr(0, end), before) + "\n" + good_text().substr(end);
    const std::string replaced = with_calibration(middle, possible());
    EXPECT_NE(replaced.find("[limits]"), std::string::npos);
    expect_same(possible(), *read_device_text(replaced, "mine.toml").calibration, 1e-8);
}

// Both sides of each limit of each number.
TEST(CalibrationFile, RefusesImpossibleNumbers) {
    const DeviceDescription kind = testing::phantom_1_0();
    for (std::size_t j = 0; j < 3; ++j) {
        for (const CalibrationField &field : calibration_fields(kind, j, possible().air_error_K)) {
            for (const auto &[limit, outward] :
                 {std::pair(field.range.minimum, -1.0), std::pair(field.range.maximum, 1.0)}) {
                const double step = 1e-6 * std::abs(limit); // the text has nine digits
                Calibration calibration = possible();
                calibration.motor[j].*field.value = limit - outward * step;
                EXPECT_EQ(error(calibration), "") << field.key;
                EXPECT_EQ(validate(calibration, kind), "") << field.key;
                calibration.motor[j].*field.value = limit + outward * step;
                const std::string message = error(calibration);
                for (const std::string &part :
                     {std::string("mine.toml:"), std::string(field.key), std::string("from"),
                      fmt::format("calibration.motor[{}]", j + 1)}) {
                    EXPECT_NE(message.find(part), std::string::npos) << part << ": " << message;
                }
                EXPECT_EQ(message.find('\n'), std::string::npos);
                EXPECT_NE(validate(calibration, kind).find(field.key), std::string::npos);
            }
        }
    }
    for (const double absurd : {std::nan(""), HUGE_VAL, -HUGE_VAL, 0.0, 1e300}) {
        Calibration calibration = possible();
        calibration.motor[1].resistance_Ohm = absurd;
        EXPECT_NE(error(calibration), "") << absurd;
        EXPECT_NE(validate(calibration, kind), "") << absurd;
    }
}

// R of another motor than the file's: 5 % of it, 1 % of the sensor, 0.78 % for 2 K, 0.5 % of noise.
TEST(CalibrationFile, RefusesAnotherMotor) {
    Calibration calibration = possible();
    calibration.motor[2].resistance_Ohm = 2.18 * 1.072;
    EXPECT_EQ(error(calibration), "");
    calibration.motor[2].resistance_Ohm = 2.18 * 1.074;
    EXPECT_NE(error(calibration).find("calibration.motor[3].resistance_Ohm"), std::string::npos);
}

TEST(CalibrationFile, RefusesWhatIsMissingOrUnknown) {
    const auto expect = [](const std::string &from, const std::string &to, const char *part) {
        const std::string message = error(possible(), from, to);
        EXPECT_NE(message.find(part), std::string::npos) << part << ": " << message;
        EXPECT_NE(message.find("mine.toml:"), std::string::npos) << message;
        EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    };
    expect("serial = ", "serail = ", "serial");
    expect("05:10:22Z", "05:10:62Z", "date");
    expect("2025-11-25T", "25.11.2025 ", "date");
    expect("air_error_K = 2", "air_error_K = 0", "air_error_K");
    expect("air_C = 21.5", "air_C = 121.5", "air_C");
    expect("ripple_cos_2_Ohm = ", "# ", "ripple_cos_2_Ohm");
    expect("offset_A = ", "gain = 1\noffset_A = ", "gain");
    expect("resistance_Ohm = ", "resistance_Ohm = \"2\" # ", "resistance_Ohm");
    expect("[[calibration.motor]]", "[[calibration.joint]]", "motor");
    expect("[calibration]", "[calibrations]", "serial");
}

// Wherever a disk was full, or an editor slipped: an error of one line, or a calibration in range.
TEST(CalibrationFile, CutAnywhereIsRefusedOrPossible) {
    const std::string whole = with_calibration(good_text(), possible());
    int refused = 0;
    for (std::size_t size = good_text().size(); size < whole.size(); size += 7) {
        try {
            const DeviceDescription read = read_device_text(whole.substr(0, size), "cut.toml");
            if (read.calibration) {
                EXPECT_EQ(validate(*read.calibration, read), "") << size;
            }
        } catch (const InputError &error) {
            ++refused;
            EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
        }
    }
    EXPECT_GT(refused, 100);
}

TEST(CalibrationFile, IsOfOneDevice) {
    DeviceDescription device = testing::phantom_1_0();
    EXPECT_NO_THROW(require_calibration_of(device, "any"));
    device.calibration = possible();
    EXPECT_NO_THROW(require_calibration_of(device, "board-7"));
    const std::string message = error_text_of([&] { require_calibration_of(device, "board-8"); });
    for (const char *part : {"board-7", "board-8", "device calibrate"}) {
        EXPECT_NE(message.find(part), std::string::npos) << message;
    }
}

} // namespace
} // namespace springdrive::device
