// Covers device/core/device_file.cpp and, through it, base/strict_toml.cpp.
#include "device/core/device_file.h"

#include "base/input_error.h"
#include "tests/support/devices.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <numbers>
#include <string>
#include <vector>

namespace springdrive::device {
namespace {

std::string good_text() {
    std::ifstream file(testing::assets() / "devices/phantom_1_0.toml");
    return {std::istreambuf_iterator<char>(file), {}};
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

} // namespace
} // namespace springdrive::device
