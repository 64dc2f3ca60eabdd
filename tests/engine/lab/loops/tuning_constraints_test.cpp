// Covers engine/lab/loops/tuning_constraints.cpp.
#include "engine/lab/loops/tuning_constraints.h"

#include "device/core/phantom/kinematics.h"
#include "tests/support/devices.h"
#include "tests/support/random_loops.h"
#include "tests/support/stability_cases.h"

#include <gtest/gtest.h>

#include <numeric>
#include <random>
#include <set>
#include <string>
#include <vector>

namespace springdrive::loops {
namespace {

TEST(TuningConstraints, HasEveryHandAndEta) {
    const TuningConstraints loops(testing::firm());
    std::set<std::string> hands;
    std::set<double> etas;
    int together = 0;
    for (std::size_t i = 0; i < loops.count(); ++i) {
        hands.insert(loops[i].hand);
        etas.insert(loops[i].eta);
        together += loops[i].share.rows() == 3 ? 1 : 0;
    }
    for (const Hand &hand : hand_family()) {
        EXPECT_EQ(hands.count(hand.name), 1U) << hand.name;
    }
    EXPECT_EQ(*etas.begin(), 0.0);
    EXPECT_EQ(*etas.rbegin(), 1.0);
    EXPECT_GE(etas.size(), 5U);
    EXPECT_GT(together, 0);
    EXPECT_GT(static_cast<int>(loops.count()) - together, 0);
}

/// The loops of one motor at a time are those of the case, and of the whole at its configuration.
TEST(TuningConstraints, AgreesWithTheCase) {
    std::mt19937_64 random(41);
    for (int i = 0; i < 20; ++i) {
        testing::Draw draw(random);
        StabilityCase which = testing::firm();
        which.period_s = draw.by_ratio(5e-4, 2e-3);
        which.delay_periods = 0.4 * (i % 6); // 0 and 2 among them
        const TuningConstraints loops(which);
        which.tuning.K_P_V_per_rad = draw.by_ratio(1.0, 100.0);
        which.tuning.K_D_Vs_per_rad = draw.even(0.0, 0.05);
        which.tuning.lambda_rad_per_s = draw.by_ratio(100.0, 5000.0);
        const Gains gains = gains_of(which.tuning);
        for (const Freedom freedom : {Freedom::one_motor, Freedom::three_motors}) {
            which.freedom = freedom;
            for (const double eta : {0.0, 0.5, 1.0}) {
                which.tuning.eta = eta;
                const Eigen::Index size = freedom == Freedom::one_motor ? 1 : 3;
                // The case's own configuration comes first, with this subdivision of hands.
                which.hands = hand_family(size == 1 ? 41 : 9);
                const std::size_t wanted = members(which).size();
                std::size_t seen = 0;
                bool all = true;
                for (std::size_t k = 0; k < loops.count() && seen < wanted; ++k) {
                    if (loops[k].share.rows() == size && loops[k].eta == eta) {
                        ++seen;
                        all = loops.is_stable(k, gains) && all;
                    }
                }
                EXPECT_EQ(seen, wanted);
                EXPECT_EQ(all, is_stable(which)) << i << ", η " << eta;
            }
        }
    }
}

TEST(TuningConstraints, FindsAnUnstableOneWhereThereIsOne) {
    TuningConstraints loops(testing::firm());
    std::vector<std::size_t> all(loops.count());
    std::iota(all.begin(), all.end(), std::size_t{0});
    for (const double K_P : {5.0, 20.0, 25.0, 28.0, 31.0, 60.0, 500.0}) {
        const Gains gains{K_P, 0.01, 1000.0};
        const std::size_t failed = loops.first_unstable(gains);
        EXPECT_EQ(failed == loops.count(), loops.are_stable(all, gains)) << K_P;
        if (failed != loops.count()) {
            EXPECT_FALSE(loops.is_stable(failed, gains));
            EXPECT_EQ(loops.first_unstable(gains), failed) << "tried first, as it failed lately";
        }
    }
    EXPECT_TRUE(loops.are_stable({}, {1e9, 1e9, 1e3}));
}

TEST(TuningConstraints, LieWithinTheWorkspace) {
    // Every configuration beyond the case's own is where the device can be.
    const TuningConstraints loops(testing::firm());
    std::size_t three = 0;
    for (std::size_t i = 0; i < loops.count(); ++i) {
        three += loops[i].share.rows() == 3 ? 1 : 0;
    }
    const std::size_t of_one = hand_family(9).size() * 8;
    EXPECT_EQ(three % of_one, 0U);
    const device::DeviceDescription device = testing::phantom_1_0();
    std::size_t reachable = 1;
    for (int i = 0; i < 27; ++i) {
        const int layer = i / 9 - 1;
        const Vector3 share(layer, i / 3 % 3 - 1, i % 3 - 1);
        const Vector3 point_m =
            device.workspace.centre_m + 0.5 * share.cwiseProduct(device.workspace.size_m);
        reachable += device::can_reach(device, point_m) ? 1 : 0;
    }
    EXPECT_EQ(three / of_one, reachable);
}

TEST(TuningConstraints, OfASeparateRotorAreOnlyItsOwn) {
    StabilityCase which = testing::firm();
    which.rotor = device::RotorLoad{1e-5, 1e-4, 0.0};
    const TuningConstraints loops(which);
    EXPECT_EQ(loops.count(), hand_family(41).size() * 8);
    for (std::size_t i = 0; i < loops.count(); ++i) {
        EXPECT_EQ(loops[i].share.rows(), 1);
    }
}

} // namespace
} // namespace springdrive::loops
