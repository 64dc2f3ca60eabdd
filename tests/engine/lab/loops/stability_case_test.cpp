// Covers engine/lab/loops/stability_case.cpp.
#include "engine/lab/loops/stability_case.h"

#include "device/core/phantom/dynamics.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/motion_control.h"
#include "engine/control/tuning.h"
#include "engine/lab/loops/tuning_constraints.h"
#include "tests/support/configurations.h"
#include "tests/support/devices.h"
#include "tests/support/sampled_loop.h"
#include "tests/support/stability_cases.h"

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::loops {
namespace {

using testing::phantom_1_0;

StabilityCase three_motors(const device::DeviceDescription &device, const Vector3 &q_rad) {
    StabilityCase which;
    which.device = device;
    which.freedom = Freedom::three_motors;
    which.q_rad = q_rad;
    return which;
}

double largest_of(const Eigen::MatrixXd &matrix) { return matrix.eigenvalues().real().maxCoeff(); }

/// Motors that differ by up to a half in k_T.
device::DeviceDescription with_unequal_motors(std::mt19937_64 &random) {
    device::DeviceDescription device = phantom_1_0();
    for (device::MotorParameters &motor : device.motor) {
        motor.torque_constant_Nm_per_A *= testing::Draw(random).even(0.7, 1.4);
    }
    return device;
}

/// Its middle is the relaxed grip; the ends are farther by a factor of 5 in mass and damping and of
/// 10 in stiffness.
TEST(HandFamily, RunsFromNoHandOverALightToAFirmOne) {
    const device::HandParameters relaxed;
    for (const double firmness : {0.0, 0.5, 1.0}) {
        const Hand hand = hand_of_firmness(firmness);
        const double five = std::pow(5.0, 2.0 * firmness - 1.0);
        const double ten = std::pow(10.0, 2.0 * firmness - 1.0);
        EXPECT_NEAR(hand.mass_kg, relaxed.mass_kg * five, 1e-12);
        EXPECT_NEAR(hand.damping_Ns_per_m, relaxed.damping_Ns_per_m * five, 1e-12);
        EXPECT_NEAR(hand.stiffness_N_per_m, relaxed.stiffness_N_per_m * ten, 1e-9);
    }
    for (const int grips : {2, 5, 41}) {
        const std::vector<Hand> hands = hand_family(grips);
        ASSERT_EQ(hands.size(), static_cast<std::size_t>(grips) + 1);
        EXPECT_EQ(hands.front().mass_kg + hands.front().damping_Ns_per_m +
                      hands.front().stiffness_N_per_m,
                  0.0);
        EXPECT_EQ(hands.front().name, "no hand");
        EXPECT_EQ(hands[1].name, "light");
        EXPECT_EQ(hands.back().name, "firm");
        for (std::size_t i = 1; i < hands.size(); ++i) {
            const Hand expected = hand_of_firmness((static_cast<double>(i) - 1.0) / (grips - 1));
            EXPECT_EQ(hands[i].mass_kg, expected.mass_kg);
            EXPECT_EQ(hands[i].damping_Ns_per_m, expected.damping_Ns_per_m);
            EXPECT_EQ(hands[i].stiffness_N_per_m, expected.stiffness_N_per_m);
        }
    }
}

TEST(HeldShare, AtTheBoundTheLargestModeIsTheInverseMaps) {
    std::mt19937_64 random(1);
    for (int i = 0; i < 50; ++i) {
        const device::DeviceDescription device = with_unequal_motors(random);
        StabilityCase which =
            three_motors(device, testing::random_workspace_angles(device, random));
        which.tuning.map = control::MotionMap::inverse;
        EXPECT_TRUE(held_share(which).isIdentity());
        which.tuning.map = control::MotionMap::transpose;
        which.tuning.alpha_mode = control::AlphaMode::on_the_fly;
        EXPECT_NEAR(largest_of(held_share(which)), 1.0, 1e-9); // (29)
        which.tuning.alpha_mode = control::AlphaMode::by_hand;
        const Matrix3 J = device::motor_jacobian(device.geometry, which.q_rad);
        which.tuning.alpha_rad2_per_m2 =
            0.4 * control::alpha_bound(J, control::relative_stiffness(device));
        which.tuning.eta = 0.25;
        EXPECT_NEAR(largest_of(held_share(which)), 0.75 * 0.4, 1e-9);
        which.freedom = Freedom::one_motor;
        EXPECT_NEAR(held_share(which)(0, 0), 0.75 * 0.4, 1e-12);
    }
}

TEST(HeldShare, TheGlobalScaleExceedsNoBound) {
    const device::DeviceDescription device = phantom_1_0();
    const Vector3 half_m = 0.5 * device.workspace.size_m;
    double largest = 0.0;
    // The corners and middles of the box are points of the grid over which the bound is taken.
    for (int i = 0; i < 27; ++i) {
        const int layer = i / 9 - 1;
        const Vector3 share(i % 3 - 1, i / 3 % 3 - 1, layer);
        const std::optional<Vector3> q_rad = device::joint_angles_rad(
            device.geometry, device.workspace.centre_m + half_m.cwiseProduct(share));
        if (!q_rad || !device.joint_limits.allow(*q_rad)) {
            continue;
        }
        StabilityCase which = three_motors(device, *q_rad);
        which.tuning.alpha_mode = control::AlphaMode::global;
        largest = std::max(largest, largest_of(held_share(which)));
    }
    EXPECT_LE(largest, 1.0 + 1e-9);
    EXPECT_GT(largest, 0.3) << "somewhere it is of use";
}

/// By energies: of links by their own dynamics, of rotors and hand by their speeds.
TEST(DrivenLoad, HasTheEnergyOfAllThatMoves) {
    std::mt19937_64 random(2);
    const Hand hand = hand_of_firmness(0.7);
    for (int i = 0; i < 20; ++i) {
        const device::DeviceDescription device = phantom_1_0();
        const Vector3 q_rad = testing::random_workspace_angles(device, random);
        const StabilityCase which = three_motors(device, q_rad);
        const DrivenLoad load = driven_load(which, {0, hand});
        const Vector3 theta_rate = testing::random_vector(random, 10.0);
        const Vector3 q_rate = device::joint_from_motor(device.geometry, theta_rate);
        constexpr double kStep_s = 1e-6;
        const Vector3 tip_rate =
            (device::tip_position_m(device.geometry, q_rad + kStep_s * q_rate) -
             device::tip_position_m(device.geometry, q_rad - kStep_s * q_rate)) /
            (2.0 * kStep_s);
        const device::LinkageMoments moments =
            device::linkage_moments(device.geometry, device.inertia, 0.0);
        const double inertia = q_rate.dot(device::mass_matrix(moments, q_rad) * q_rate) +
                               device.motor[0].rotor_inertia_kg_m2 * theta_rate.squaredNorm() +
                               hand.mass_kg * tip_rate.squaredNorm();
        const double damping = device.friction.viscous_Nms_per_rad * q_rate.squaredNorm() +
                               hand.damping_Ns_per_m * tip_rate.squaredNorm();
        const double stiffness = hand.stiffness_N_per_m * tip_rate.squaredNorm();
        const auto power = [&](const Eigen::MatrixXd &matrix) {
            return theta_rate.dot(matrix * theta_rate);
        };
        EXPECT_NEAR(power(load.inertia_kg_m2), inertia, 1e-8 * inertia);
        EXPECT_NEAR(power(load.damping_Nms_per_rad), damping, 1e-8 * damping);
        EXPECT_NEAR(power(load.stiffness_Nm_per_rad), stiffness, 1e-8 * stiffness);
        EXPECT_EQ(load.inertia_kg_m2, load.inertia_kg_m2.transpose());
    }
}

/// A loop of one motor, as verified in sampled_loop_test.cpp.
SampledLoop loop_of(const StabilityCase &which, const LoopMember &member, double share) {
    SampledLoop loop;
    loop.drive.motor = which.device.motor[static_cast<std::size_t>(member.motor)];
    loop.drive.tuning = which.tuning;
    loop.drive.tuning.eta = 1.0 - share;
    loop.drive.period_s = which.period_s;
    loop.drive.delay_periods = which.delay_periods;
    const Matrix3 J = device::motor_jacobian(which.device.geometry, which.q_rad);
    const double lever = J.col(member.motor).squaredNorm();
    const double N = which.device.geometry.transmission_ratio[member.motor];
    const device::LinkageMoments moments =
        device::linkage_moments(which.device.geometry, which.device.inertia, 0.0);
    loop.device = {device::mass_matrix(moments, which.q_rad)(member.motor, member.motor) / (N * N),
                   which.device.friction.viscous_Nms_per_rad / (N * N), 0.0};
    loop.hand = {member.hand.mass_kg * lever, member.hand.damping_Ns_per_m * lever,
                 member.hand.stiffness_N_per_m * lever};
    return loop;
}

TEST(StabilityCase, OneMotorIsTheSampledLoop) {
    std::mt19937_64 random(3);
    for (int i = 0; i < 30; ++i) {
        testing::Draw draw(random);
        StabilityCase which;
        which.device = phantom_1_0();
        which.device.motor.fill(testing::random_motor(random));
        which.tuning = testing::random_tuning(which.device.motor[0], random);
        which.period_s = draw.by_ratio(2e-4, 2e-3);
        which.delay_periods = i % 4;
        which.q_rad = testing::random_workspace_angles(which.device, random);
        const LoopMember member{i % 3, hand_of_firmness(draw.even(0.0, 1.0))};
        const double truth = largest_eigenvalue(loop_of(which, member, 1.0 - which.tuning.eta));
        EXPECT_NEAR(largest_eigenvalue(which, member), truth, 1e-9);
    }
}

/// Where the links are perpendicular and q₂ = q₃, the motors are decoupled, both in inertia and
/// through the hand.
TEST(StabilityCase, APerpendicularLinkageIsThreeLoopsOfOneMotor) {
    std::mt19937_64 random(4);
    testing::Draw draw(random);
    for (int i = 0; i < 20; ++i) {
        const double fold = draw.even(-0.4, 0.6);
        StabilityCase which = three_motors(phantom_1_0(), {draw.even(-0.5, 0.5), fold, fold});
        which.tuning = testing::random_tuning(which.device.motor[0], random);
        which.tuning.map = i % 2 == 0 ? control::MotionMap::inverse : control::MotionMap::transpose;
        which.delay_periods = i % 3;
        const Hand hand = hand_of_firmness(draw.even(0.0, 1.0));
        const Eigen::MatrixXd share = held_share(which);
        double truth = 0.0;
        for (int j = 0; j < 3; ++j) {
            truth = std::max(truth, largest_eigenvalue(loop_of(which, {j, hand}, share(j, j))));
        }
        EXPECT_NEAR(largest_eigenvalue(which, {0, hand}), truth, 1e-9);
        which.q_rad[2] -= 0.3; // elsewhere they are coupled
        EXPECT_GT(std::abs(driven_load(which, {0, hand}).inertia_kg_m2(1, 2)), 1e-8);
    }
}

TEST(StabilityCase, HasEveryHandOnEveryMotor) {
    StabilityCase which;
    which.device = phantom_1_0();
    EXPECT_EQ(members(which).size(), 18U);
    which.freedom = Freedom::three_motors;
    EXPECT_EQ(members(which).size(), 6U);
    which.freedom = Freedom::one_motor;
    which.rotor = device::RotorLoad{1e-5, 1e-5, 0.0};
    EXPECT_EQ(members(which).size(), 6U);
    which.hands = {no_hand()};
    EXPECT_EQ(members(which).size(), 1U);
}

TEST(StabilityCase, TheWorstMemberIsTheWorst) {
    StabilityCase which;
    which.device = phantom_1_0();
    which.tuning.K_P_V_per_rad = 29.0;
    const WorstMember worst = worst_member(which);
    EXPECT_EQ(worst.eigenvalue, largest_eigenvalue(which, worst.member));
    for (const LoopMember &member : members(which)) {
        EXPECT_LE(largest_eigenvalue(which, member), worst.eigenvalue);
    }
    EXPECT_EQ(worst.is_stable(), is_stable(which));
    EXPECT_TRUE(is_stable(which));
    which.tuning.K_P_V_per_rad = 40.0;
    EXPECT_FALSE(is_stable(which));
}

TEST(StabilityCase, ANetResistanceReplacesTheTunings) {
    StabilityCase which;
    which.device = phantom_1_0();
    const device::MotorParameters &motor = which.device.motor[0];
    EXPECT_EQ(which.dR_Ohm(motor), 0.5);
    which.tuning.dR_Ohm = 0.0;
    EXPECT_EQ(which.dR_Ohm(motor), device::kMinResidualShare * motor.resistance_Ohm);
    which.net_resistance_Ohm = -0.3;
    EXPECT_EQ(which.dR_Ohm(motor), -0.3);
    const DrivenLoad load = driven_load(which, {0, no_hand()});
    EXPECT_DOUBLE_EQ(load.current_rate_per_current[0], 0.3 / motor.inductance_H);
}

/// F = −K x − B ẋ at the tip does Jᵀ F at the motors, whatever their k_T.
TEST(SampledLaw, OfACurrentDriveIsTheWallAtTheTip) {
    std::mt19937_64 random(5);
    const device::DeviceDescription device = with_unequal_motors(random);
    StabilityCase which = three_motors(device, {0.3, 0.2, -0.2});
    which.drive = device::AmplifierKind::current_drive;
    which.wall = {400.0, 3.0};
    which.tuning.eta = 0.5;
    const LoopMember member{0, no_hand()};
    const SampledLaw law = sampled_law(which, member);
    const Matrix3 J = device::motor_jacobian(device.geometry, which.q_rad);
    const Vector3 theta = testing::random_vector(random, 1.0);
    const Vector3 force_N = 0.5 * -400.0 * (J * theta);
    const Vector3 torque =
        driven_load(which, member).torque_Nm_per_A.cwiseProduct(law.per_position * theta);
    EXPECT_LT((torque - J.transpose() * force_N).norm(), 1e-12);
    const Vector3 damping =
        driven_load(which, member).torque_Nm_per_A.cwiseProduct(law.per_velocity * theta);
    EXPECT_LT((damping - J.transpose() * (force_N * 3.0 / 400.0)).norm(), 1e-12);
}

TEST(StabilityParameters, HaveUniqueNamesAndSearchWithinTheirRange) {
    std::set<std::string_view> names;
    for (const StabilityParameter &parameter : stability_parameters()) {
        SCOPED_TRACE(parameter.name);
        EXPECT_TRUE(names.insert(parameter.name).second);
        EXPECT_EQ(stability_parameter_named(parameter.name), &parameter);
        EXPECT_NE(names_of_stability_parameters().find(parameter.name), std::string::npos);
        EXPECT_FALSE(parameter.help.empty());
        EXPECT_LT(parameter.from, parameter.to);
        for (const double good :
             {parameter.from, parameter.to, parameter.minimum, parameter.maximum}) {
            EXPECT_EQ(validate(parameter, good), "");
        }
        const double infinity = std::numeric_limits<double>::infinity();
        for (const double bad :
             {std::nextafter(parameter.minimum, -infinity),
              std::nextafter(parameter.maximum, infinity), std::nan(""), infinity, -infinity}) {
            const std::string wrong = validate(parameter, bad);
            EXPECT_EQ(wrong.find(parameter.name), 0U) << wrong;
            EXPECT_NE(wrong.find(" from "), std::string::npos) << wrong;
            EXPECT_EQ(wrong.find('\n'), std::string::npos);
        }
    }
    EXPECT_EQ(stability_parameter_named("K_P"), nullptr);
    EXPECT_EQ(stability_parameter_named(""), nullptr);
    EXPECT_NE(validate(testing::named("dR"), 0.0).find("not 0"), std::string::npos);
    EXPECT_EQ(validate(testing::named("d"), 1.5), "");
    EXPECT_NE(validate(testing::named("d"), 8.5).find("0 to 8 periods"), std::string::npos);
}

TEST(StabilityParameters, GetWhatWasSetAndLeaveTheOthersAlone) {
    for (const StabilityParameter &parameter : stability_parameters()) {
        for (const double share : {0.0, 0.3, 1.0}) {
            const double value = parameter.from + share * (parameter.to - parameter.from);
            StabilityCase which = testing::firm();
            parameter.set(which, value);
            EXPECT_EQ(parameter.get(which), value) << parameter.name;
            for (const StabilityParameter &other : stability_parameters()) {
                if (&other != &parameter) {
                    EXPECT_EQ(other.get(which), other.get(testing::firm()))
                        << parameter.name << " moves " << other.name;
                }
            }
        }
    }
}

/// So that a limit that is found can also be set, in a file and by a slider.
TEST(StabilityParameters, AreSearchedNoFurtherThanGainsCanBeSet) {
    for (const control::Parameter &parameter : control::kParameters) {
        if (parameter.value == &control::Tuning::K_P_V_per_rad ||
            parameter.value == &control::Tuning::K_D_Vs_per_rad) {
            EXPECT_GE(parameter.maximum, stability_parameter_named(parameter.option)->to)
                << parameter.name;
        }
    }
}

TEST(StabilityParameters, AnInertiaOfItsOwnStartsAsTheSecondMotors) {
    StabilityCase which = testing::firm();
    const double damping = stability_parameter_named("damping")->get(which);
    const DrivenLoad load = driven_load(which, {1, no_hand()});
    EXPECT_EQ(damping, load.damping_Nms_per_rad(0, 0));
    stability_parameter_named("inertia")->set(which, 3e-5);
    ASSERT_TRUE(which.rotor);
    EXPECT_EQ(which.rotor->damping_Nms_per_rad, damping);
    EXPECT_EQ(driven_load(which, {1, no_hand()}).inertia_kg_m2(0, 0), 3e-5);
}

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
                const std::size_t requested = members(which).size();
                std::size_t seen = 0;
                bool all = true;
                for (std::size_t k = 0; k < loops.count() && seen < requested; ++k) {
                    if (loops[k].share.rows() == size && loops[k].eta == eta) {
                        ++seen;
                        all = loops.is_stable(k, gains) && all;
                    }
                }
                EXPECT_EQ(seen, requested);
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
