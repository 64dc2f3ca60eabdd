// Covers device/device_file.cpp and, through it, base/strict_toml.cpp.
#include "device/device_file.h"

#include "base/input_error.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>

namespace springdrive {
namespace {

std::string good_text() {
    std::ifstream file(testing::assets() / "devices/phantom_1_0.toml");
    return {std::istreambuf_iterator<char>(file), {}};
}

/// The message for the good file with its first `from` replaced by `to`.
std::string complaint(const std::string &from, const std::string &to) {
    std::string text = good_text();
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    // Tests run side by side, each in its own process.
    const std::string test = ::testing::UnitTest::GetInstance()->current_test_info()->name();
    const std::filesystem::path file =
        std::filesystem::path(::testing::TempDir()) / ("device_file_" + test + ".toml");
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
    const std::filesystem::path file =
        std::filesystem::path(::testing::TempDir()) / "device_file_three.toml";
    std::ofstream(file) << text;
    const DeviceDescription device = read_device_file(file);
    EXPECT_EQ(device.motor[0].resistance_Ohm, 2.18);
    EXPECT_EQ(device.motor[1].resistance_Ohm, 3.25);
    EXPECT_EQ(device.motor[2].resistance_Ohm, 2.18);
}

TEST(DeviceFile, RefusesWhatCannotBeByNameLineAndRange) {
    expect_all(complaint("0.238e-3", "-1e-3"), {":56:", "motor.inductance_H", "-0.001", "from"});
    expect_all(complaint("0.238e-3", "nan"), {"motor.inductance_H", "from"});
    expect_all(complaint("0.238e-3", "inf"), {"motor.inductance_H", "from"});
    expect_all(complaint("0.238e-3", "\"much\""), {"motor.inductance_H", "much"});
    expect_all(complaint("[13.3, 11.2, 11.2]", "[13.3, 0, 11.2]"),
               {"linkage.transmission_ratio", "three numbers"});
    expect_all(complaint("[13.3, 11.2, 11.2]", "[13.3, 11.2]"), {"three numbers"});
    expect_all(complaint("4096", "4096.5"), {"encoder.counts_per_turn", "whole number"});
    expect_all(complaint("resistance_Ohm = 2.18", ""), {"motor.resistance_Ohm", "missing"});
    expect_all(complaint("resistance_Ohm", "resistence_Ohm"), {"missing"});
    expect_all(complaint("supply_V", "colour = 1\nsupply_V"), {"motor.colour", "not known"});
    expect_all(complaint("[0.0, 0.030, -0.015]", "[0.0, 1.0, 0.0]"),
               {"workspace.centre_m", "out of reach"});
    expect_all(complaint("highest_deg = [90.0, 119.0,", "highest_deg = [90.0, 2.0,"),
               {"workspace.centre_m", "joint_limits"});
    expect_all(complaint("centre_m = -0.0239", "centre_m = -0.239"),
               {"inertia.upper_arm.inertia_kg_m2", "at least", "0.0134748"}); // 0.2359 · 0.239²
    expect_all(complaint("[limits]", "[limit]"), {"limits", "missing"});
    expect_all(complaint("mass_kg = 0.0166", "mass_kg = -0.0166"),
               {"inertia.forearm.mass_kg", "-0.0166", "from"});
    expect_all(complaint("base_kg_m2 = 5.01e-4", "base_kg_m2 = nan"),
               {"inertia.base_kg_m2", "from"});
    expect_all(complaint("[0.270e-4, 0.270e-4,", "[-0.270e-4, 0.270e-4,"),
               {"inertia.forearm.inertia_kg_m2"});
    expect_all(complaint("centre_m = -0.0239", "centre_mm = -23.9"),
               {"inertia.upper_arm.centre_m", "missing"});
    expect_all(complaint("coulomb_Nm = [0.0056,", "coulomb_Nm = [-0.0056,"),
               {"friction.coulomb_Nm"});
    expect_all(complaint("least_q3_minus_q2_deg = -65.0", "least_q3_minus_q2_deg = -95.0"),
               {"joint_limits.least_q3_minus_q2_deg", "-95", "-89"});
    expect_all(complaint("winding_time_s = 12.0", "winding_time_s = 0"),
               {"motor.winding_time_s", "from"});
    expect_all(complaint("name = ", "name : "), {":2:", "not valid TOML"});
    expect_all(complaint("0.1397 ", "139.7 "), {"linkage.upper_arm_m", "139.7"}); // millimetres
}

TEST(DeviceFile, RefusesAnAmplifierThatCancelsMoreThanItMay) {
    // 2.18 Ω and an excess of 0.63 Ω make 2.81 Ω.
    EXPECT_EQ(complaint("greatest_cancelled_Ohm = 2.8 ", "greatest_cancelled_Ohm = 2.809 "), "");
    expect_all(complaint("greatest_cancelled_Ohm = 2.8 ", "greatest_cancelled_Ohm = 2.811 "),
               {"amplifier.greatest_cancelled_Ohm", "2.811", "from 0 to 2.81"});
    expect_all(complaint("greatest_excess_Ohm = 0.63", "greatest_excess_Ohm = -1"),
               {"amplifier.greatest_excess_Ohm", "from"});
}

TEST(DeviceFile, RefusesAFileThatIsNotThere) {
    EXPECT_THROW(static_cast<void>(read_device_file("no such file.toml")), InputError);
    EXPECT_THROW(static_cast<void>(read_device_file(testing::assets())), InputError);
}

} // namespace
} // namespace springdrive
