// Covers device/core/device_file.cpp.
#include "device/core/device_file.h"

#include "base/error_text.h"
#include "base/input_error.h"
#include "tests/support/devices.h"
#include "tests/support/files.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace springdrive::device {
namespace {

std::string kind_text() {
    return testing::contents_of(testing::assets() / "devices/phantom_1_0.toml");
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
    std::string text = with_calibration(kind_text(), calibration);
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
    const std::string text = with_calibration(kind_text(), possible());
    EXPECT_EQ(text.find(kind_text()), 0U);
    const DeviceDescription read = read_device_text(text, "mine.toml");
    ASSERT_TRUE(read.calibration);
    expect_same(possible(), *read.calibration, 1e-8); // nine digits
    EXPECT_NE(text.find("date = \"2025-11-25T05:10:22Z\""), std::string::npos) << text;
    EXPECT_FALSE(read_device_text(kind_text(), "kind.toml").calibration);
}

TEST(CalibrationFile, ReplacesTheOneBefore) {
    Calibration before = possible();
    before.serial = "another \"one\" \\ [calibration]";
    before.made_at_s = 0;
    const std::string once = with_calibration(kind_text(), before);
    EXPECT_EQ(read_device_text(once, "mine.toml").calibration->serial, before.serial);
    EXPECT_EQ(text_of_utc(0), "1970-01-01T00:00:00Z");
    EXPECT_EQ(with_calibration(once, possible()), with_calibration(kind_text(), possible()));

    // Also in the middle of a file: what follows stays.
    const std::size_t end = kind_text().find("[limits]");
    const std::string middle =
        with_calibration(kind_text().substr(0, end), before) + "\n" + kind_text().substr(end);
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
    const std::string whole = with_calibration(kind_text(), possible());
    int refused = 0;
    for (std::size_t size = kind_text().size(); size < whole.size(); size += 7) {
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
