// Covers engine/control/tuning_difference.cpp.
#include "engine/control/tuning_difference.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

namespace springdrive::control {
namespace {

std::string difference(const Tuning &before, const Tuning &after) {
    return text_of(changes_between(before, after));
}

/// The change of K_P from one value to another, as "before → after".
std::string change_of_K_P(double before_V_per_rad, double after_V_per_rad) {
    const std::vector<TuningChange> changes =
        changes_between({.K_P_V_per_rad = before_V_per_rad}, {.K_P_V_per_rad = after_V_per_rad});
    return changes.size() == 1 ? changes[0].before + " → " + changes[0].after : "not one change";
}

TEST(TuningDifference, IsOneLine) {
    const Tuning before{.map = MotionMap::inverse};
    const Tuning after{.dR_Ohm = 0.3, .K_P_V_per_rad = 8.0};
    EXPECT_EQ(difference(before, after),
              "dR 0.5 → 0.3 Ω, K_P 6 → 8 V/rad, map inverse (18) → transpose (23)");
    EXPECT_EQ(difference({}, {.eta = 0.25, .alpha_mode = AlphaMode::global}),
              "η 0 → 0.25, source α on the fly → global α");
    EXPECT_EQ(difference(after, after), "no difference");
}

TEST(TuningDifference, NamesEveryParameterAsItsRowDoes) {
    for (const Parameter &parameter : kParameters) {
        Tuning before{.alpha_mode = AlphaMode::by_hand};
        Tuning after = before;
        before.*parameter.value = parameter.minimum;
        after.*parameter.value = parameter.maximum;
        const std::vector<TuningChange> changes = changes_between(before, after);
        ASSERT_EQ(changes.size(), 1U) << parameter.name;
        EXPECT_EQ(changes[0].name, parameter.name);
        EXPECT_EQ(changes[0].symbol, parameter.symbol);
        EXPECT_EQ(changes[0].unit.empty(), parameter.value == &Tuning::eta);
        EXPECT_EQ(std::stod(changes[0].before), parameter.minimum);
        EXPECT_EQ(std::stod(changes[0].after), parameter.maximum);
    }
}

TEST(TuningDifference, NamesAlphaOnlyWhereItActs) {
    const Tuning on_the_fly{.alpha_rad2_per_m2 = 1000.0};
    const Tuning global{.alpha_rad2_per_m2 = 2000.0, .alpha_mode = AlphaMode::global};
    const Tuning by_hand{.alpha_rad2_per_m2 = 3000.0, .alpha_mode = AlphaMode::by_hand};
    EXPECT_EQ(difference(on_the_fly, global), "source α on the fly → global α");
    EXPECT_EQ(difference(on_the_fly, by_hand),
              "α 1000 → 3000 rad²/m², source α on the fly → α by hand");
    EXPECT_EQ(difference(by_hand, global), "α 3000 → 2000 rad²/m², source α by hand → global α");
    EXPECT_EQ(difference(on_the_fly, {.alpha_rad2_per_m2 = 1500.0}), "no difference");
}

TEST(TuningDifference, HasAsManyDigitsAsTellTheValuesApart) {
    EXPECT_EQ(change_of_K_P(6.0, 13.445854187011719), "6 → 13.4");
    EXPECT_EQ(change_of_K_P(13.445854187011719, 13.4500001), "13.4 → 13.5");
    EXPECT_EQ(change_of_K_P(13.445854187011719, 13.4459), "13.44585 → 13.4459");
    EXPECT_EQ(change_of_K_P(0.1 + 0.2, 0.3), "0.30000000000000004 → 0.3");
    EXPECT_EQ(change_of_K_P(1234.5678, 20'000.4), "1235 → 20000");
    EXPECT_EQ(change_of_K_P(999.96, 1e-5), "1000 → 1e-05");
    EXPECT_EQ(change_of_K_P(0.0, std::numeric_limits<double>::denorm_min()), "0 → 5e-324");
    EXPECT_EQ(change_of_K_P(0.0, -0.0), "not one change");
}

TEST(TuningDifference, NeverShowsDifferentNumbersAsTheSame) {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> exponent(-6.0, 6.0);
    std::uniform_real_distribution<double> closeness(-17.0, 0.0);
    int changed = 0;
    for (int i = 0; i < 20'000; ++i) {
        const double before = std::pow(10.0, exponent(random));
        const double after = before * (1.0 + std::pow(10.0, closeness(random)));
        const std::vector<TuningChange> changes =
            changes_between({.K_P_V_per_rad = before}, {.K_P_V_per_rad = after});
        ASSERT_EQ(changes.size(), before == after ? 0U : 1U);
        if (!changes.empty()) {
            ++changed;
            EXPECT_NE(changes[0].before, changes[0].after);
            // Half a unit of the third digit.
            EXPECT_NEAR(std::stod(changes[0].before) / before, 1.0, 5.001e-3);
            EXPECT_NEAR(std::stod(changes[0].after) / after, 1.0, 5.001e-3);
        }
    }
    EXPECT_GT(changed, 10'000);
}

TEST(TuningDifference, APresetSetsTheGainsAndNothingElse) {
    const Tuning active{.alpha_rad2_per_m2 = 1000.0,
                        .eta = 0.2,
                        .map = MotionMap::inverse,
                        .alpha_mode = AlphaMode::by_hand};
    const Tuning preset{.dR_Ohm = 0.2,
                        .K_P_V_per_rad = 13.0,
                        .K_D_Vs_per_rad = 0.02,
                        .lambda_rad_per_s = 5000.0,
                        .alpha_rad2_per_m2 = 4000.0};
    const Tuning result = with_gains_of(active, preset);
    EXPECT_EQ(difference(active, result), "dR 0.5 → 0.2 Ω, K_P 6 → 13 V/rad, K_D 0.01 → 0.02 "
                                          "V·s/rad, λ 1000 → 5000 rad/s");
    EXPECT_EQ(with_gains_of(result, preset), result);
    EXPECT_EQ(with_gains_of(preset, active),
              (Tuning{.alpha_rad2_per_m2 = preset.alpha_rad2_per_m2}));
}

/// A new parameter is set by presets or is kept, on purpose.
TEST(TuningDifference, EveryParameterIsAGainOfPresetsOrKept) {
    const std::vector<double Tuning::*> kept{&Tuning::alpha_rad2_per_m2, &Tuning::eta};
    for (const Parameter &parameter : kParameters) {
        EXPECT_EQ(std::ranges::count(kGainsOfPresets, parameter.value) +
                      std::ranges::count(kept, parameter.value),
                  1)
            << parameter.name;
    }
}

} // namespace
} // namespace springdrive::control
