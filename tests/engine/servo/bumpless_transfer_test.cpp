// Covers engine/servo/bumpless_transfer.cpp.
#include "engine/servo/bumpless_transfer.h"

#include "engine/control/tuning.h"
#include "tests/support/configurations.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>

namespace springdrive::servo {
namespace {

BumplessTransfer transfer_at(double period_s) { return {testing::phantom_1_0(), period_s}; }

/// e_W of the law with its offset.
Vector3 carried_on_V(BumplessTransfer &transfer, const Vector3 &law_V,
                     const std::optional<Vector3> &unchanged_V, bool scene_is_new = false,
                     bool is_felt = true) {
    transfer.carry(law_V, unchanged_V, scene_is_new, is_felt);
    return law_V + transfer.transfer_offset_V();
}

TEST(BumplessTransfer, NoChangeMovesTheVoltageByMoreThanItsBound) {
    // A law that varies by itself and is changed occasionally: the output follows the law to within
    // the bound. All values are within the supply.
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> chance(0.0, 1.0);
    for (const double period_s : {1.0 / 250, 1e-3, 1e-4}) {
        const double bound_V = kMaxChange_V_per_s * period_s;
        BumplessTransfer transfer = transfer_at(period_s);
        Vector3 set_V = testing::random_vector(random, 3.0);
        Vector3 own_V = Vector3::Zero(); // the law's own variation
        Vector3 out_V = carried_on_V(transfer, set_V, std::nullopt);
        EXPECT_EQ(out_V, set_V);
        int changes = 0;
        for (int tick = 0; tick < 20'000; ++tick) {
            const Vector3 moved_V = testing::random_vector(random, 0.5) - own_V;
            own_V += moved_V;
            std::optional<Vector3> unchanged_V;
            if (chance(random) < 0.05) {
                unchanged_V = set_V + own_V;
                set_V = testing::random_vector(random, 3.0);
                ++changes;
            }
            const Vector3 law_V = set_V + own_V;
            const Vector3 now_V = carried_on_V(transfer, law_V, unchanged_V);
            ASSERT_LE((now_V - out_V - moved_V).cwiseAbs().maxCoeff(), bound_V + 1e-12);
            out_V = now_V;
        }
        EXPECT_GT(changes, 500);
    }
}

TEST(BumplessTransfer, DecaysToExactlyZeroInTheExpectedTime) {
    BumplessTransfer transfer = transfer_at(1e-3);
    const Vector3 before_V(2.0, -1.0, 0.02);
    for (int tick = 1; tick <= 41; ++tick) {
        const Vector3 now_V = carried_on_V(transfer, Vector3::Zero(),
                                           tick == 1 ? std::optional(before_V) : std::nullopt);
        EXPECT_NEAR(now_V[0], std::max(0.0, 2.0 - 0.05 * tick), 1e-12);
        EXPECT_NEAR(now_V[1], -std::max(0.0, 1.0 - 0.05 * tick), 1e-12);
        EXPECT_EQ(now_V[2], 0.0);
    }
    EXPECT_EQ(transfer.transfer_offset_V(), Vector3::Zero()); // exactly
}

TEST(BumplessTransfer, LimitsTheOffsetToTheSupply) {
    const double supply_V = testing::phantom_1_0().motor[0].supply_V;
    BumplessTransfer transfer = transfer_at(1e-3);
    const Vector3 far_V = Vector3::Constant(10.0 * supply_V);
    const Vector3 now_V = carried_on_V(transfer, Vector3::Zero(), far_V);
    EXPECT_NEAR(now_V[0], supply_V - 0.05, 1e-12);
}

TEST(BumplessTransfer, StartsANewSceneWithTheLastVoltage) {
    BumplessTransfer transfer = transfer_at(1e-3);
    transfer.carry(Vector3(1.0, 0.0, 0.0), std::nullopt, false, true);
    const Vector3 now_V = carried_on_V(transfer, Vector3(0.0, 0.3, 0.01), std::nullopt, true);
    EXPECT_LT((now_V - Vector3(0.95, 0.05, 0.01)).norm(), 1e-12);
}

TEST(BumplessTransfer, HasNoOffsetWhileMotorsAreOff) {
    BumplessTransfer transfer = transfer_at(1e-3);
    transfer.carry(Vector3::Zero(), Vector3::Ones(), false, true);
    EXPECT_NE(transfer.transfer_offset_V(), Vector3::Zero());
    transfer.carry(Vector3::Ones(), Vector3::Zero(), false, false);
    EXPECT_EQ(transfer.transfer_offset_V(), Vector3::Zero());
}

TEST(BumplessTransfer, MovesParametersSmoothlyToTheirTargets) {
    constexpr double kPeriod_s = 1e-3;
    constexpr double kGlide_s = 0.05;
    LawSettings wanted;
    wanted.tuning.K_P_V_per_rad = 25.0;
    wanted.tuning.eta = 0.4;
    wanted.tuning.map = control::MotionMap::inverse;
    wanted.global_alpha_rad2_per_m2 = 1234.0;
    BumplessTransfer transfer = transfer_at(kPeriod_s);
    const control::Tuning start = transfer.active().tuning;
    for (int tick = 1; tick <= 1500; ++tick) {
        transfer.approach(wanted, true);
        const control::Tuning &now = transfer.active().tuning;
        EXPECT_EQ(now.map, wanted.tuning.map); // immediately: the step of e_W is compensated
        EXPECT_EQ(transfer.active().global_alpha_rad2_per_m2, 1234.0);
        const double left = std::exp(-tick * kPeriod_s / kGlide_s);
        for (const control::Parameter &parameter : control::kParameters) {
            const double end = wanted.tuning.*parameter.value;
            const double range = parameter.maximum - parameter.minimum;
            EXPECT_NEAR(now.*parameter.value, end + left * (start.*parameter.value - end),
                        1e-6 * range) // the final step
                << parameter.name;
        }
    }
    EXPECT_EQ(transfer.active(), wanted);
    EXPECT_FALSE(transfer.has_changed());
}

TEST(BumplessTransfer, LimitsTheRateOfTheCancelledVoltage) {
    const device::DeviceDescription device = testing::phantom_1_0();
    for (const double period_s : {1e-3, 1e-4}) {
        LawSettings wanted;
        wanted.tuning.dR_Ohm = 3.0;
        BumplessTransfer transfer(device, period_s);
        double before_Ohm = transfer.active().tuning.dR_Ohm;
        double fastest_V_per_s = 0.0;
        for (int tick = 0; tick < 300; ++tick) {
            transfer.approach(wanted, true);
            const double now_Ohm = transfer.active().tuning.dR_Ohm;
            fastest_V_per_s =
                std::max(fastest_V_per_s,
                         (now_Ohm - before_Ohm) * device.motor[0].peak_current_A / period_s);
            before_Ohm = now_Ohm;
        }
        EXPECT_NEAR(fastest_V_per_s, kMaxChange_V_per_s, 1e-6);
    }
}

TEST(BumplessTransfer, ChangesImmediatelyWhileMotorsAreOff) {
    LawSettings wanted;
    wanted.tuning.K_P_V_per_rad = 25.0;
    wanted.tuning.dR_Ohm = 3.0;
    BumplessTransfer transfer = transfer_at(1e-3);
    transfer.approach(wanted, false);
    EXPECT_EQ(transfer.active(), wanted);
    EXPECT_TRUE(transfer.has_changed());
    EXPECT_EQ(transfer.before(), LawSettings{});
    transfer.approach(wanted, false);
    EXPECT_FALSE(transfer.has_changed());
}

} // namespace
} // namespace springdrive::servo
