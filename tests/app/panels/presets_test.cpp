// Covers app/panels/presets.cpp and the tunings in assets/tunings.
#include "app/panels/presets.h"

#include "engine/control/tuning_file.h"
#include "engine/lab/limits/auto_tune.h"
#include "engine/lab/loops/tuning_constraints.h"
#include "tests/support/devices.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <string>
#include <string_view>

namespace springdrive::app {
namespace {

control::TuningFile read(std::string_view name) {
    return control::read_whole_tuning_file(testing::assets() / "tunings" /
                                           (std::string(name) + ".toml"));
}

TEST(Presets, AreTheFilesInTheFolder) {
    std::set<std::string> named;
    for (const Preset &preset : kPresets) {
        EXPECT_NE(std::find(kPresetLabels.begin(), kPresetLabels.end(), preset.label),
                  kPresetLabels.end());
        named.insert(std::string(preset.file) + ".toml");
    }
    std::set<std::string> there;
    for (const auto &entry : std::filesystem::directory_iterator(testing::assets() / "tunings")) {
        there.insert(entry.path().filename());
    }
    EXPECT_EQ(named, there);
}

TEST(Presets, DependOnTheServo) {
    EXPECT_EQ(preset_file("soft", 250.0, 3.0), "soft");
    EXPECT_EQ(preset_file("firm", 10'000.0, 0.0), "firm");
    EXPECT_EQ(preset_file("stiffest", 999.0, 0.0), "");
    EXPECT_EQ(preset_file("stiffest", 1.0 / 1e-3, 0.0), "stiffest_1kHz");
    EXPECT_EQ(preset_file("stiffest", 3999.0, 0.0), "stiffest_1kHz");
    EXPECT_EQ(preset_file("stiffest", 1.0 / 2.5e-4, 0.0), "stiffest_4kHz");
    EXPECT_EQ(preset_file("stiffest", 10'000.0, 0.0), "stiffest_4kHz");
    EXPECT_EQ(preset_file("stiffest", 4000.0, 0.5), "");
    EXPECT_EQ(preset_file("softest", 1000.0, 0.0), "");
}

/// The stiffest are what `springdrive tune` found for their servo rate, and at no rate for which
/// they are offered is the margin gone.
TEST(Presets, TheStiffestAreStableAtEveryRateForWhichTheyAreOffered) {
    for (const double servo_hz : {1000.0, 1500.0, 2500.0, 3999.0, 4000.0, 6000.0, 10'000.0}) {
        const std::string name = preset_file("stiffest", servo_hz, 0.0);
        const control::TuningFile file = read(name);
        loops::StabilityCase which;
        which.device = testing::phantom_1_0();
        which.tuning = file.tuning;
        which.period_s = 1.0 / servo_hz;
        loops::TuningConstraints loops(which);
        loops::Gains gains = loops::gains_of(file.tuning);
        gains.K_P_V_per_rad *= limits::AutoTuneRequest{}.margin;
        gains.K_D_Vs_per_rad *= limits::AutoTuneRequest{}.margin;
        EXPECT_EQ(loops.first_unstable(gains), loops.count()) << name << " at " << servo_hz;
    }
}

TEST(Presets, TheStiffestHaveTheMarginsThatWereFound) {
    for (const Preset &preset : kPresets) {
        const control::TuningFile file = read(preset.file);
        EXPECT_EQ(file.margins.has_value(), preset.min_servo_hz > 0.0) << preset.file;
        if (file.margins) {
            EXPECT_NEAR(file.margins->servo_hz, preset.min_servo_hz, 1e-6) << preset.file;
            EXPECT_EQ(file.margins->delay_periods, 0.0) << preset.file;
            EXPECT_GE(file.margins->gain, limits::AutoTuneRequest{}.margin * (1.0 - 1e-3));
        }
    }
}

} // namespace
} // namespace springdrive::app
