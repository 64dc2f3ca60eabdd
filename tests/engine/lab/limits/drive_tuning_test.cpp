// Covers what tunes and compares drives: engine/lab/limits/{auto_tune,impact,wall_tune}.cpp;
// long_limits_test.cpp has the slow tests. The outputs of drive_comparison.cpp are those of
// tests/app/tuning_commands_test.cpp.
#include "base/input_error.h"
#include "device/core/phantom/dynamics.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/coupling.h"
#include "engine/control/motion_control.h"
#include "engine/control/tuning.h"
#include "engine/lab/limits/auto_tune.h"
#include "engine/lab/limits/drive_comparison.h"
#include "engine/lab/limits/stability_simulation.h"
#include "engine/lab/loops/passivity.h"
#include "engine/lab/loops/rendered_stiffness.h"
#include "tests/support/devices.h"
#include "tests/support/stability_cases.h"

#include <Eigen/LU>
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

/// Of a whole device, for a load of its own has no structure.
TEST(FoundWithStructure, ThePassiveOneBearsWhatTheStiffestDoesNot) {
    AutoTuneRequest whole = request_for(1000.0, 0, 0.5);
    whole.which.rotor.reset();
    whole.which.hands = {loops::no_hand(), loops::hand_of_firmness(0.5)};
    for (const bool is_passive : {true, false}) {
        whole.is_passive = is_passive;
        const AutoTuned found = auto_tune(whole);
        EXPECT_EQ(found.gain_with_structure > 1.0, is_passive);
        loops::StabilityCase which = tuned(whole, found.tuning);
        which.structures = loops::all_structures();
        for (const double factor : {0.995, 1.005}) {
            const double gain = factor * found.gain_with_structure;
            which.tuning.K_P_V_per_rad = gain * found.tuning.K_P_V_per_rad;
            which.tuning.K_D_Vs_per_rad = gain * found.tuning.K_D_Vs_per_rad;
            which.freedom = loops::Freedom::one_motor;
            bool is_stable = loops::is_stable(which);
            which.freedom = loops::Freedom::three_motors;
            is_stable = is_stable && loops::is_stable(which);
            EXPECT_EQ(is_stable, factor < 1.0) << is_passive;
        }
    }
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

/// Passive up to kPassiveMargin and not beyond, and no pair of K_D and λ of a grid allows more.
TEST_F(FoundTuning, APassiveOneIsSofterAndTheStiffestOfAGrid) {
    AutoTuneRequest wary = request;
    wary.which.delay_periods = 0.0;
    wary.is_passive = true;
    const AutoTuned passive = auto_tune(wary);
    EXPECT_EQ(passive.coupling, "passive");
    const auto is_passive = [&](const loops::Gains &gains) {
        loops::StabilityCase which = wary.which;
        which.tuning.K_P_V_per_rad = kPassiveMargin * gains.K_P_V_per_rad;
        which.tuning.K_D_Vs_per_rad = kPassiveMargin * gains.K_D_Vs_per_rad;
        which.tuning.lambda_rad_per_s = gains.lambda_rad_per_s;
        return loops::passivity(which).holds();
    };
    EXPECT_TRUE(is_passive(loops::gains_of(passive.tuning)));
    EXPECT_EQ(passive.taken_back, 0.0); // else the grid is no judge
    for (double K_D = 0.0; K_D < 0.02; K_D += 0.0004) {
        for (double lambda = 100.0; lambda <= 5000.0; lambda *= 1.1) {
            EXPECT_FALSE(is_passive({1.01 * passive.tuning.K_P_V_per_rad, K_D, lambda}))
                << K_D << ' ' << lambda;
        }
    }
    wary.is_passive = false;
    const AutoTuned stable_only = auto_tune(wary);
    EXPECT_NE(stable_only.coupling, "passive");
    EXPECT_GT(stable_only.margins.K_DC_Nm_per_rad, passive.margins.K_DC_Nm_per_rad);
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
        const std::string said =
            error_text_of([&request] { static_cast<void>(auto_tune(request)); });
        EXPECT_NE(said.find(key), std::string::npos) << request.margin << ": " << said;
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

/// By a hand that continues at its speed.
loops::StabilityCase held_firmly(double period_s) {
    loops::StabilityCase which;
    which.device = testing::phantom_1_0();
    which.period_s = period_s;
    which.hands = {{"leading", 0.0, 200.0, 20000.0}};
    return which;
}

/// A wall of a current drive, a spring alone, with that resolution of the encoders.
loops::StabilityCase spring_wall(double period_s, int counts_per_turn) {
    loops::StabilityCase which = held_firmly(period_s);
    which.drive = device::AmplifierKind::current_drive;
    which.device.encoder_counts_per_turn = counts_per_turn;
    which.wall = {500.0, 0.0};
    return which;
}

/// A spring alone: the force grows by K times the displacement, so that rate over speed is K,
/// except for the initial lag of half a sample.
TEST(Impact, OfAPlainSpringIsItsStiffness) {
    const Impact found = impact(spring_wall(1e-4, testing::phantom_1_0().encoder_counts_per_turn));
    EXPECT_NEAR(found.rate_hardness_N_per_m, 500.0, 0.05 * 500.0);
    EXPECT_NEAR(found.max_force_N, 500.0 * 0.1 * 0.01, 0.1 * 0.5); // 10 ms at 0.1 m/s
}

/// A whole sample late, a tick sees the force of the tick before, which 1 to 10 ms after the
/// contact is by 10 % and more too small. Between ticks the force is that of the wall. A delay that
/// is part of a period postpones the force by as much: at a rate-hardness read within 10 ms, by a
/// share of d T/10 ms.
TEST(Impact, IsReadBetweenTicksTooAndFallsWithAnyDelay) {
    loops::StabilityCase which = spring_wall(1e-3, 1 << 20);
    const double at_once = impact(which).rate_hardness_N_per_m;
    EXPECT_NEAR(at_once, 500.0, 0.05 * 500.0);
    for (const double d : {0.5, 1.0, 2.5}) {
        which.delay_periods = d;
        EXPECT_NEAR(impact(which).rate_hardness_N_per_m / at_once, 1.0 - 0.1 * d, 0.03) << d;
    }
}

/// M with rotors, through J along the vertical: the mass of an unpowered current drive for a hand
/// that guides it along a line.
TEST(MeasuredMass, OfACurrentDriveIsTheLinkagesOwn) {
    loops::StabilityCase which = held_firmly(1e-4);
    which.drive = device::AmplifierKind::current_drive;
    const device::DeviceDescription &device = which.device;
    const device::LinkageMoments moments =
        device::linkage_moments(device.geometry, device.inertia, device.inertia.tip_load_kg);
    Matrix3 M = device::mass_matrix(moments, which.q_rad);
    for (Eigen::Index j = 0; j < 3; ++j) {
        const double N = device.geometry.transmission_ratio[j];
        M(j, j) += N * N * device.motor[0].rotor_inertia_kg_m2;
    }
    const Matrix3 J = device::joint_jacobian(device.geometry, which.q_rad);
    // Sideways the hand is stiff, so the tip keeps to the vertical: q̇ = J⁻¹ e_y ẏ.
    const Vector3 rate = J.inverse() * Vector3::UnitY();
    const double truth = rate.dot(M * rate);
    EXPECT_NEAR(apparent_mass_kg(which), truth, 0.03 * truth); // ±10 mm change M by a few per cent
}

/// k_T² τ/dR of each motor on top, τ the loop's whole lag (docs/design.md, "Contact and maps").
TEST(MeasuredMass, OfASpringDriveHasTheLagsToo) {
    const loops::StabilityCase which = held_firmly(1e-3);
    const double spring = apparent_mass_kg(which);
    loops::StabilityCase bare = which;
    bare.drive = device::AmplifierKind::current_drive;
    const double own = apparent_mass_kg(bare);
    const control::Coupling c =
        control::coupling(which.device.motor[0], which.tuning, which.period_s, 0);
    const Vector3 rate =
        device::motor_jacobian(which.device.geometry, which.q_rad).inverse() * Vector3::UnitY();
    const double truth = c.added_inertia_kg_m2 * rate.squaredNorm();
    EXPECT_NEAR(spring - own, truth, 0.05 * truth); // 5 Hz is not rest
}

constexpr double kMargin = 1.3;

loops::StabilityCase late_servo() {
    loops::StabilityCase which;
    which.device = testing::phantom_1_0();
    which.delay_periods = 1;
    which.hands = {loops::no_hand(), loops::hand_of_firmness(0.5)};
    return which;
}

loops::StabilityCase with(const TunedWall &tuned, double factor) {
    loops::StabilityCase which = late_servo();
    which.drive = device::AmplifierKind::current_drive;
    which.tuning.lambda_rad_per_s = tuned.lambda_rad_per_s;
    which.wall = {factor * tuned.wall.stiffness_N_per_m, factor * tuned.wall.damping_Ns_per_m};
    return which;
}

bool holds(loops::StabilityCase which) {
    which.freedom = loops::Freedom::one_motor;
    const bool each = loops::is_stable(which);
    which.freedom = loops::Freedom::three_motors;
    return each && loops::is_stable(which);
}

/// The stiffest, which the tests share.
const TunedWall &unlimited() {
    static const TunedWall tuned = tuned_wall(late_servo(), kMargin);
    return tuned;
}

TEST(TunedWall, LeavesItsMarginAndNoMore) {
    const TunedWall &tuned = unlimited();
    ASSERT_GT(tuned.wall.stiffness_N_per_m, 100.0);
    EXPECT_TRUE(holds(with(tuned, 1.0)));
    EXPECT_TRUE(holds(with(tuned, 0.999 * kMargin)));
    // With K alone a tenth larger the margin is lost: it is the largest with its B and λ.
    loops::StabilityCase stiffer = with(tuned, kMargin);
    stiffer.wall.stiffness_N_per_m *= 1.1;
    EXPECT_FALSE(holds(stiffer));
    EXPECT_TRUE(is_stable_simulated(with(tuned, 1.0),
                                    TrialOptions::with(SimulationEffects::electronics())));
}

/// Over an independent grid: no combination of K, B and λ exceeds it by more than the spacing of
/// its own grid.
TEST(TunedWall, IsTheStiffest) {
    const TunedWall &tuned = unlimited();
    for (int i = 0; i < 14; ++i) {
        const double B = std::pow(1.35, i); // up to 50
        for (int j = 0; j < 5; ++j) {
            const double lambda = 150.0 * std::pow(2.4, j); // up to 5000
            const TunedWall alternative{{1.06 * tuned.wall.stiffness_N_per_m, B}, lambda};
            EXPECT_FALSE(holds(with(alternative, kMargin))) << "B " << B << " λ " << lambda;
        }
    }
}

TEST(TunedWall, RespectsTheLimitOnTheForceOfACount) {
    const double large_N = loops::force_of_a_count_N(with(unlimited(), 1.0));
    const TunedWall quiet = tuned_wall(late_servo(), kMargin, 0.25 * large_N);
    ASSERT_GT(quiet.wall.stiffness_N_per_m, 0.0);
    EXPECT_LE(loops::force_of_a_count_N(with(quiet, 1.0)), 0.25 * large_N);
    EXPECT_TRUE(holds(with(quiet, kMargin)));
}

} // namespace
} // namespace springdrive::limits
