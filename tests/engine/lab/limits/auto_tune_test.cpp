// Covers engine/lab/limits/auto_tune.cpp; auto_tune_search_test.cpp has the slow tests.
#include "engine/lab/limits/auto_tune.h"

#include "base/input_error.h"
#include "engine/control/tuning.h"
#include "engine/lab/limits/stability_simulation.h"
#include "tests/support/random_loops.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

namespace springdrive::limits {
namespace {

AutoTuneRequest request_for(double servo_hz, int delay, double dR_Ohm) {
    AutoTuneRequest request;
    request.which.device = testing::phantom_1_0();
    request.which.rotor = device::RotorLoad{1.4e-5, 4e-6, 0.0}; // about its second motor's: quick
    request.which.tuning.dR_Ohm = dR_Ohm;
    request.which.period_s = 1.0 / servo_hz;
    request.which.delay_periods = delay;
    return request;
}

loops::StabilityCase tuned(const AutoTuneRequest &request, const control::Tuning &tuning) {
    loops::StabilityCase which = request.which;
    which.tuning = tuning;
    return which;
}

bool holds(const loops::StabilityCase &which, double gain) {
    loops::TuningConstraints loops(which);
    return loops.first_unstable({gain * which.tuning.K_P_V_per_rad,
                                 gain * which.tuning.K_D_Vs_per_rad,
                                 which.tuning.lambda_rad_per_s}) == loops.count();
}

/// One found tuning that several tests share.
class FoundTuning : public ::testing::Test {
protected:
    static void SetUpTestSuite() {
        request = request_for(1000.0, 1, 0.5);
        found = auto_tune(request);
    }
    static AutoTuneRequest request;
    static AutoTuned found;
};
AutoTuneRequest FoundTuning::request; // NOLINT(cert-err58-cpp)
AutoTuned FoundTuning::found;         // NOLINT(cert-err58-cpp)

TEST_F(FoundTuning, IsValid) {
    EXPECT_EQ(validate(found.tuning), "");
    EXPECT_EQ(found.tuning.eta, 0.0);
    EXPECT_EQ(found.tuning.dR_Ohm, 0.5);
    EXPECT_EQ(found.tuning.map, request.which.tuning.map);
    EXPECT_GT(found.tuning.K_P_V_per_rad, 0.0);
    EXPECT_EQ(found.loops, loops::TuningConstraints(request.which).count());
    const double k_T = request.which.device.motor[0].torque_constant_Nm_per_A;
    EXPECT_DOUBLE_EQ(found.margins.K_DC_Nm_per_rad,
                     k_T * found.tuning.K_P_V_per_rad / 0.5); // (13)
}

TEST_F(FoundTuning, HasTheRequestedMarginAndNoMore) {
    const loops::StabilityCase which = tuned(request, found.tuning);
    EXPECT_GE(found.margins.gain, request.margin * (1.0 - 1e-3));
    EXPECT_TRUE(holds(which, found.margins.gain));
    EXPECT_FALSE(holds(which, found.margins.gain * 1.002));
    if (found.taken_back == 0.0 && found.tuning.K_P_V_per_rad < request.max_K_P_V_per_rad) {
        EXPECT_LT(found.margins.gain, request.margin * 1.05);
    }
}

TEST_F(FoundTuning, HasTheReportedDelayMargin) {
    loops::StabilityCase which = tuned(request, found.tuning);
    which.delay_periods += found.margins.more_delay_periods;
    EXPECT_TRUE(holds(which, 1.0));
    ++which.delay_periods;
    EXPECT_FALSE(holds(which, 1.0));
    EXPECT_EQ(found.margins.delay_periods, 1);
    EXPECT_NEAR(found.margins.servo_hz, 1000.0, 1e-9);
}

TEST_F(FoundTuning, HasTheReportedResistanceMargin) {
    loops::StabilityCase which = tuned(request, found.tuning);
    which.net_resistance_Ohm = found.margins.min_dR_Ohm;
    EXPECT_TRUE(holds(which, 1.0));
    which.net_resistance_Ohm = found.margins.min_dR_Ohm - 0.011 * 0.5;
    EXPECT_FALSE(holds(which, 1.0));
}

TEST_F(FoundTuning, ComesToRestWithCountsInEveryHand) {
    EXPECT_TRUE(is_stable_simulated(tuned(request, found.tuning),
                                    TrialOptions::with(SimulationEffects::electronics())));
}

TEST_F(FoundTuning, IsTheSameEveryTime) {
    const AutoTuned again = auto_tune(request);
    EXPECT_EQ(again.tuning.K_P_V_per_rad, found.tuning.K_P_V_per_rad);
    EXPECT_EQ(again.tuning.K_D_Vs_per_rad, found.tuning.K_D_Vs_per_rad);
    EXPECT_EQ(again.tuning.lambda_rad_per_s, found.tuning.lambda_rad_per_s);
}

TEST_F(FoundTuning, AWiderMarginIsSofter) {
    AutoTuneRequest careful = request;
    careful.margin = 2.0;
    const AutoTuned softer = auto_tune(careful);
    EXPECT_LT(softer.margins.K_DC_Nm_per_rad, found.margins.K_DC_Nm_per_rad);
    EXPECT_GE(softer.margins.gain, 2.0 * (1.0 - 1e-3));
}

/// Every hand of the family and others between them, at any η.
void expect_stable_in_every_hand(loops::StabilityCase which) {
    which.hands = loops::hand_family(41);
    for (int i = 0; i <= 20; ++i) {
        which.tuning.eta = i / 20.0;
        const loops::WorstMember worst = loops::worst_member(which);
        EXPECT_TRUE(worst.is_stable())
            << worst.member.hand.name << ", η " << which.tuning.eta << ": " << worst.eigenvalue;
    }
}

/// Between the family's five hands there are others: in free space this motor is unstable with a
/// hand of firmness 0.2, but with none of the five, if the filter is slow enough for gains to be
/// high.
TEST(AutoTune, IsStableInHandsBetweenTheFive) {
    AutoTuneRequest request = request_for(798.0, 3, 0.0393656);
    request.margin = 2.41629;
    request.which.rotor = device::RotorLoad{2.34187e-6, 1.75902e-7, 0.0};
    for (device::MotorParameters &motor : request.which.device.motor) {
        motor.resistance_Ohm = 0.781578;
        motor.inductance_H = 0.147964e-3;
        motor.torque_constant_Nm_per_A = 0.0322198;
    }
    const AutoTuned found = auto_tune(request);
    expect_stable_in_every_hand(tuned(request, found.tuning));
    loops::StabilityCase five = tuned(request, found.tuning);
    five.tuning.eta = 1.0;
    five.tuning.lambda_rad_per_s = 338.274;
    EXPECT_TRUE(loops::is_stable(five)) << "or this does not test what it says";
    five.hands = loops::hand_family(41);
    EXPECT_FALSE(loops::is_stable(five)) << "or this does not test what it says";
}

TEST(AutoTune, IsStableInHandsThatItWasNotGiven) {
    std::mt19937_64 random(61);
    for (int i = 0; i < 3; ++i) {
        AutoTuneRequest request;
        request.which = testing::random_rotor_loop(random);
        request.which.hands = loops::hand_family();
        request.which.tuning.dR_Ohm = std::clamp(request.which.tuning.dR_Ohm, 0.02, 2.18);
        request.margin = testing::Draw(random).even(1.0, 3.0);
        expect_stable_in_every_hand(tuned(request, auto_tune(request).tuning));
    }
}

TEST(AutoTune, ReportsItsProgressAndCanBeCancelled) {
    std::vector<double> told;
    EXPECT_THROW(static_cast<void>(auto_tune(request_for(1000.0, 1, 0.5),
                                             [&told](double share) {
                                                 told.push_back(share);
                                                 return told.size() < 3;
                                             })),
                 InputError);
    EXPECT_EQ(told.size(), 3U);
    EXPECT_TRUE(std::is_sorted(told.begin(), told.end()));
}

TEST(AutoTune, RefusesInvalidMarginsAndReportsWhereNothingIsStable) {
    AutoTuneRequest request = request_for(1000.0, 0, 0.5);
    const auto expect_error = [&request](const char *key) {
        try {
            static_cast<void>(auto_tune(request));
            FAIL() << key;
        } catch (const InputError &error) {
            EXPECT_NE(std::string(error.what()).find(key), std::string::npos) << request.margin;
        }
    };
    for (const double bad : {0.0, 0.999, 10.001, std::nan(""), HUGE_VAL, -1.3}) {
        request.margin = bad;
        expect_error("1 to 10");
    }
    // An over-cancelled winding has no stable free space, whatever the gains.
    request = request_for(1000.0, 0, 0.5);
    request.which.net_resistance_Ohm = -0.5;
    expect_error("no tuning");
}

} // namespace
} // namespace springdrive::limits
