// Covers what panels compute: the stiffness that a touch has met (app/panels/hand_tab.cpp), the
// shipped tunings (app/panels/tuning_editor.h, assets/tunings), the field of the stability tab
// (app/panels/stability_tab.h), except its drawing, and app/panels/tuning_editor.cpp.
#include "app/panels/panels.h"
#include "app/panels/stability_tab.h"
#include "app/panels/tuning_editor.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/tuning.h"
#include "engine/control/tuning_file.h"
#include "engine/lab/limits/auto_tune.h"
#include "engine/lab/loops/passivity.h"
#include "engine/lab/loops/tuning_constraints.h"
#include "engine/session/telemetry_history.h"
#include "tests/engine/session/session_fixture.h"
#include "tests/support/devices.h"
#include "tests/support/files.h"
#include "tests/support/stability_cases.h"
#include "tests/support/tunings.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <random>
#include <set>
#include <string>
#include <string_view>

namespace springdrive::app {
namespace {

/// Ticks of a contact under a wall of this stiffness, pressed to `depth_m` and back.
session::TelemetryHistory pressed(double stiffness_N_per_m, double depth_m, double noise_N) {
    session::TelemetryHistory history(testing::phantom_1_0().geometry, 1000.0);
    std::mt19937_64 random(5);
    std::normal_distribution<> noise(0.0, 1.0);
    const Vector3 normal = Vector3(0.3, 0.9, -0.2).normalized();
    for (int tick = 0; tick < 1000; ++tick) {
        servo::ServoSample sample;
        sample.time_s = 1e-3 * tick;
        const double depth = depth_m * std::sin(3.14 * tick / 1000.0);
        sample.contact.touching = tick > 100; // before: free, however large the force
        sample.contact.normal = normal;
        sample.contact.x0_m = depth * normal;
        // A force across the normal must not count.
        const Vector3 across = normal.cross(Vector3::UnitX());
        sample.tip_force_N = (stiffness_N_per_m * depth + 0.2 + noise_N * noise(random)) * normal +
                             3.0 * std::sin(0.1 * tick) * across;
        history.add(sample);
    }
    return history;
}

TEST(MeasuredStiffness, IsTheSlopeOfTheForceAlongTheNormal) {
    for (const double stiffness : {50.0, 1300.0, 9000.0}) {
        const auto history = pressed(stiffness, 0.004, 0.0);
        const StiffnessMeasured found = measured_stiffness(history.store(), 0.0, 1.0);
        EXPECT_NEAR(found.slope_N_per_m, stiffness, 1e-6 * stiffness);
        EXPECT_LT(found.deviation_N_per_m, 1e-3 * stiffness);
    }
}

TEST(MeasuredStiffness, ItsDeviationIsThatOfItsErrors) {
    const auto history = pressed(1300.0, 0.004, 0.1);
    const StiffnessMeasured found = measured_stiffness(history.store(), 0.0, 1.0);
    EXPECT_NEAR(found.slope_N_per_m, 1300.0, 4.0 * found.deviation_N_per_m);
    // σ/√Σ(x − x̄)², of some 900 ticks whose depths spread by 1.2 mm.
    EXPECT_NEAR(found.deviation_N_per_m, 0.1 / (std::sqrt(900.0) * 0.0012), 1.0);
}

TEST(MeasuredStiffness, NeedsAChangeOfDepth) {
    const auto still = pressed(1300.0, 2e-5, 0.0);
    EXPECT_TRUE(std::isnan(measured_stiffness(still.store(), 0.0, 1.0).slope_N_per_m));
    const auto history = pressed(1300.0, 0.004, 0.0);
    EXPECT_TRUE(std::isnan(measured_stiffness(history.store(), 0.0, 0.09).slope_N_per_m)); // free
    EXPECT_TRUE(std::isnan(measured_stiffness(history.store(), 5.0, 6.0).slope_N_per_m));
}

control::TuningFile read(std::string_view name) {
    return control::read_whole_tuning_file(testing::tuning_path(std::string(name)));
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
/// they are offered is a margin gone.
TEST(Presets, TheStiffestArePassiveAtEveryRateForWhichTheyAreOffered) {
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
        which.tuning.K_P_V_per_rad *= limits::kPassiveMargin;
        which.tuning.K_D_Vs_per_rad *= limits::kPassiveMargin;
        EXPECT_TRUE(loops::passivity(which).holds()) << name << " at " << servo_hz;
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

TEST(StabilityGrid, SpreadsByRatioBetweenItsEnds) {
    EXPECT_GT(StabilityGrid::K_P_V_per_rad(0), StabilityGrid::kMin_K_P_V_per_rad);
    EXPECT_LT(StabilityGrid::K_P_V_per_rad(StabilityGrid::kColumns - 1),
              StabilityGrid::kMax_K_P_V_per_rad);
    const double ratio = StabilityGrid::dR_Ohm(1) / StabilityGrid::dR_Ohm(0);
    EXPECT_NEAR(StabilityGrid::dR_Ohm(9) / StabilityGrid::dR_Ohm(8), ratio, 1e-12);
    // Half a cell lies beyond the centres of the outermost.
    EXPECT_NEAR(StabilityGrid::dR_Ohm(0) * StabilityGrid::dR_Ohm(StabilityGrid::kRows - 1),
                StabilityGrid::kMin_dR_Ohm * StabilityGrid::kMax_dR_Ohm, 1e-12);
}

TEST(StabilityGrid, EveryCellIsWhatASingleTuningGives) {
    BackgroundTalk talk;
    const StabilityGrid grid = stability_grid(testing::firm(), talk);
    ASSERT_EQ(grid.eigenvalue.size(),
              static_cast<std::size_t>(StabilityGrid::kColumns * StabilityGrid::kRows));
    EXPECT_EQ(talk.share, 1.0);
    int stable = 0;
    for (int row = 0; row < StabilityGrid::kRows; row += 3) {
        for (int column = 0; column < StabilityGrid::kColumns; column += 5) {
            // Set in the tuning, whereas the grid sets the net resistance.
            loops::StabilityCase there = testing::firm();
            there.tuning.K_P_V_per_rad = StabilityGrid::K_P_V_per_rad(column);
            there.tuning.dR_Ohm = StabilityGrid::dR_Ohm(row);
            // The motors of this device are equal, so both are the same except for rounding.
            EXPECT_NEAR(grid.at(column, row), loops::worst_member(there).eigenvalue, 1e-9);
            stable += grid.at(column, row) < 1.0 ? 1 : 0;
        }
    }
    EXPECT_GT(stable, 5); // both sides of the limit occur
    EXPECT_LT(stable, 43);
}

TEST(StabilityGrid, EndsEarlyWhereItIsCancelled) {
    BackgroundTalk talk;
    talk.is_cancelled = true;
    const StabilityGrid grid = stability_grid(testing::firm(), talk);
    EXPECT_EQ(grid.at(3, 3), 0.0); // not computed
}

using control::Tuning;

Tuning random_tuning(std::mt19937_64 &random) {
    const auto between = [&random](double from, double to) {
        return from * std::pow(to / from, std::uniform_real_distribution<>(0.0, 1.0)(random));
    };
    Tuning tuning;
    tuning.dR_Ohm = between(0.05, 2.0);
    tuning.K_P_V_per_rad = between(0.5, 200.0);
    tuning.K_D_Vs_per_rad = between(1e-3, 0.5);
    tuning.lambda_rad_per_s = between(200.0, 5000.0);
    tuning.map = random() % 2 == 0 ? control::MotionMap::inverse : control::MotionMap::transpose;
    return tuning;
}

/// By the eigenvalues of every hand's loops, with K_P and K_D times `gain`.
bool is_stable(const session::Session &session, Tuning tuning, double gain) {
    tuning.K_P_V_per_rad *= gain;
    tuning.K_D_Vs_per_rad *= gain;
    return loops::is_stable(stability_case_of(session, tuning));
}

struct Rig {
    session::Session session{testing::scripted()};
    TuningEditor editor{session};
};

TEST(TuningEditor, TheLockLetsEveryStableTuningPassAndNoOther) {
    Rig rig;
    std::mt19937_64 random(11);
    const Tuning start = rig.session.tuning().now();
    int held = 0;
    int passed = 0;
    for (int i = 0; i < 300; ++i) {
        const Tuning requested = random_tuning(random);
        rig.editor.replace(start, "start");
        rig.editor.drag(requested, 1);
        rig.session.tuning().let_go();
        EXPECT_EQ(rig.session.servo().inputs().tuning, rig.session.tuning().now());
        EXPECT_TRUE(is_stable(rig.session, rig.session.tuning().now(), 1.0));
        if (is_stable(rig.session, requested, 1.021)) {
            EXPECT_EQ(rig.session.tuning().now(), requested);
            EXPECT_TRUE(rig.editor.error().empty());
            ++passed;
        } else if (!is_stable(rig.session, requested, 1.02)) {
            EXPECT_NE(rig.session.tuning().now(), requested);
            EXPECT_FALSE(rig.editor.error().empty());
            ++held;
        }
    }
    EXPECT_GT(held, 50);
    EXPECT_GT(passed, 50);
}

TEST(TuningEditor, ADragEndsAtTheLimit) {
    Rig rig;
    Tuning requested = rig.session.tuning().now();
    requested.K_P_V_per_rad = 400.0;
    rig.editor.drag(requested, 1);
    const Tuning reached = rig.session.tuning().now();
    EXPECT_GT(reached.K_P_V_per_rad, 6.0);
    EXPECT_TRUE(is_stable(rig.session, reached, 1.0));
    // 2 % more gain is unstable, to within the last halving of the way to 400 V/rad: 0.024 V/rad.
    EXPECT_FALSE(is_stable(rig.session, reached, 1.02 * (1.0 + 0.03 / reached.K_P_V_per_rad)));
}

TEST(TuningEditor, UnlockedEveryTuningPassesAndTheIndicatorFollows) {
    Rig rig;
    rig.editor.is_unlocked = true;
    Tuning requested = rig.session.tuning().now();
    requested.K_P_V_per_rad = 400.0;
    rig.editor.drag(requested, 1);
    EXPECT_EQ(rig.session.tuning().now(), requested);
    EXPECT_FALSE(rig.editor.indicator().is_stable());
    // Locked again, every way is open from there.
    rig.editor.is_unlocked = false;
    requested.K_P_V_per_rad = 300.0;
    rig.editor.drag(requested, 1);
    EXPECT_EQ(rig.session.tuning().now(), requested);
}

TEST(TuningEditor, TheIndicatorIsThatOfTheChosenHand) {
    Rig rig;
    rig.editor.is_unlocked = true;
    std::mt19937_64 random(12);
    int differing = 0;
    for (int i = 0; i < 200; ++i) {
        rig.editor.replace(random_tuning(random), "random");
        bool any_is_unstable = false;
        for (const auto &[hand, firmness] : {std::pair{IndicatorHand::light, 0.0},
                                             {IndicatorHand::relaxed, 0.5},
                                             {IndicatorHand::firm, 1.0}}) {
            rig.editor.hand = hand;
            rig.editor.update();
            loops::StabilityCase which = stability_case_of(rig.session, rig.session.tuning().now());
            which.hands = {loops::hand_of_firmness(firmness)};
            EXPECT_EQ(rig.editor.indicator().is_stable(), loops::is_stable(which));
            any_is_unstable |= !rig.editor.indicator().is_stable();
        }
        rig.editor.hand = IndicatorHand::every;
        rig.editor.update();
        if (any_is_unstable) {
            EXPECT_FALSE(rig.editor.indicator().is_stable());
        }
        rig.editor.hand = IndicatorHand::firm;
        rig.editor.update();
        differing += rig.editor.indicator().is_stable() && any_is_unstable ? 1 : 0;
    }
    EXPECT_GT(differing, 0); // some rest in a firm hand only
}

TEST(TuningEditor, WhatIsRefusedChangesNothing) {
    Rig rig;
    const Tuning start = rig.session.tuning().now();
    Tuning unstable = start;
    unstable.K_P_V_per_rad = 400.0;
    rig.editor.replace(unstable, "a file");
    EXPECT_EQ(rig.session.tuning().now(), start);
    EXPECT_NE(rig.editor.error().find("a file"), std::string::npos);
    EXPECT_FALSE(rig.session.tuning().can_undo());
    // Unlocked it becomes a step; locked again, undo works, redo is refused.
    rig.editor.is_unlocked = true;
    rig.editor.replace(unstable, "a file");
    rig.editor.is_unlocked = false;
    rig.editor.undo();
    EXPECT_EQ(rig.session.servo().inputs().tuning, start);
    rig.editor.redo();
    EXPECT_EQ(rig.session.servo().inputs().tuning, start);
    EXPECT_FALSE(rig.editor.error().empty());
}

TEST(TuningEditor, ATuningFromElsewhereIsAStep) {
    Rig rig;
    Tuning other = rig.session.tuning().now();
    other.eta = 0.5;
    rig.session.tuning().replace(other, rig.session.plot_time_s(), "by a scene's model");
    EXPECT_EQ(rig.session.servo().inputs().tuning, other);
    ASSERT_TRUE(rig.session.tuning().can_undo());
    rig.editor.undo();
    EXPECT_EQ(rig.session.servo().inputs().tuning.eta, 0.0);
}

} // namespace
} // namespace springdrive::app
