// Covers engine/servo/command_limiter.cpp and safety_limits.cpp: what of a requested command is
// passed on, and the soft wall that is added at the edge of the workspace.
#include "engine/servo/command_limiter.h"

#include "device/core/motor/winding_heat.h"
#include "device/core/phantom/kinematics.h"
#include "engine/servo/safety_limits.h"
#include "tests/support/configurations.h"
#include "tests/support/devices.h"

#include <Eigen/LU>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <random>
#include <string>

namespace springdrive::servo {
namespace {

/// One random tick of one device: the requested command, and the state.
struct Case {
    device::DeviceDescription device;
    LimiterInputs inputs;
    device::DeviceCommand requested;
};

double coldest_limit_Ohm(const device::MotorParameters &motor) {
    return (1.0 - device::kMinResidualShare) *
           device::min_resistance_Ohm(motor, device::kColdestAir_C);
}

control::Configuration at(const device::DeviceDescription &device, const Vector3 &q_rad) {
    control::Configuration now;
    now.theta_rad = device::motor_from_joint(device.geometry, q_rad);
    now.tip_m = device::tip_position_m(device.geometry, q_rad);
    now.J = device::motor_jacobian(device.geometry, q_rad);
    return now;
}

/// The joints' range without the soft wall.
device::JointLimits within_edge(const device::DeviceDescription &device) {
    device::JointLimits within = device.joint_limits;
    const double margin_rad = device.edge.margin_rad;
    within.min_rad.array() += margin_rad;
    within.max_rad.array() -= margin_rad;
    within.min_q3_minus_q2_rad += margin_rad;
    within.max_q3_minus_q2_rad -= margin_rad;
    return within;
}

class CommandLimiter : public ::testing::Test {
protected:
    double any(double minimum, double maximum) {
        return std::uniform_real_distribution<double>(minimum, maximum)(random);
    }

    Case any_case(const device::DeviceDescription &device) {
        Case c{device, {}, {}};
        c.inputs.now = at(device, testing::random_workspace_angles(device, random));
        c.inputs.now.theta_rate_rad_per_s = testing::random_vector(random, 60.0);
        c.inputs.motors = control::motors_of_file(device.motor);
        c.inputs.limits = limits_of(device);
        c.inputs.limits.voltage_V = any(1.7, 14.0); // above k_T θ̇
        c.inputs.limits.current_A = any(0.5, 7.0);
        c.inputs.limits.tip_force_N = any(0.5, 10.0);
        c.inputs.ramp = any(0.0, 1.0) < 0.5 ? 1.0 : any(0.0, 1.0);
        c.inputs.R_hat_limit_Ohm.setConstant(coldest_limit_Ohm(device.motor[0]));
        c.requested.e_W_V = testing::random_vector(random, any(0.0, 1.0) < 0.5 ? 2.0 : 30.0);
        c.requested.cancelled_resistance_Ohm.setConstant(any(-0.5, 3.0));
        return c;
    }

    /// The same with a k_T and a sensor's offset that were observed.
    Case any_observed_case(const device::DeviceDescription &device) {
        Case c = any_case(device);
        for (control::ObservedMotor &motor : c.inputs.motors) {
            motor.torque_constant_Nm_per_A *= any(0.9, 1.1);
            motor.offset_A = any(-0.02, 0.02);
        }
        return c;
    }

    std::mt19937_64 random{4};
    std::array<device::DeviceDescription, 2> devices{testing::phantom_1_0(),
                                                     testing::phantom_premium_1_5()};
};

/// dR of (6) at the smallest R of any commutator angle, limited by the amplifier.
Vector3 residual_Ohm(const device::DeviceDescription &device, const Vector3 &R_hat_Ohm) {
    Vector3 dR_Ohm;
    for (Eigen::Index j = 0; j < 3; ++j) {
        const device::MotorParameters &motor = device.motor[static_cast<std::size_t>(j)];
        dR_Ohm[j] = std::max(motor.resistance_Ohm * (1.0 - motor.commutation_ripple) - R_hat_Ohm[j],
                             device::kMinResidualShare * motor.resistance_Ohm);
    }
    return dR_Ohm;
}

/// k_T i of each motor, or its back-EMF.
Vector3 times_k_T(const Case &c, const Vector3 &value) {
    Vector3 product = value;
    for (Eigen::Index j = 0; j < 3; ++j) {
        product[j] *= c.inputs.motors[static_cast<std::size_t>(j)].torque_constant_Nm_per_A;
    }
    return product;
}

/// Steady currents of a command at constant speed, (e_W + R̂ o − k_T θ̇)/dR: the amplifier multiplies
/// a reading i + o by R̂.
Vector3 steady_current_A(const Case &c, const device::DeviceCommand &command) {
    Vector3 net_V = command.e_W_V - times_k_T(c, c.inputs.now.theta_rate_rad_per_s);
    for (Eigen::Index j = 0; j < 3; ++j) {
        net_V[j] += command.cancelled_resistance_Ohm[j] *
                    c.inputs.motors[static_cast<std::size_t>(j)].offset_A;
    }
    return net_V.cwiseQuotient(residual_Ohm(c.device, command.cancelled_resistance_Ohm));
}

/// (22) by solving Jᵀ F = k_T i.
double force_N(const Case &c, const Vector3 &current_A) {
    const Matrix3 J_transposed = c.inputs.now.J.transpose();
    return J_transposed.partialPivLu().solve(times_k_T(c, current_A)).norm();
}

TEST_F(CommandLimiter, SteadyForceAndCurrentsStayWithinTheirLimits) {
    int drawn_back = 0;
    int let_be = 0;
    std::array<int, kForceLimitNames.size()> by_limit{};
    for (int run = 0; run < 40'000; ++run) {
        const Case c = any_observed_case(devices[static_cast<std::size_t>(run % 2)]);
        const LimitedCommand result = limited(c.device, c.requested, c.inputs);
        const Vector3 current_A = steady_current_A(c, result.command);
        const double min_A = std::min(c.inputs.limits.current_A, 5.5);
        ASSERT_LE(force_N(c, current_A), kLimiterShare * c.inputs.limits.tip_force_N * (1 + 1e-9))
            << run;
        ASSERT_LE(current_A.cwiseAbs().maxCoeff(), kLimiterShare * min_A * (1 + 1e-9)) << run;
        ASSERT_LE(result.command.e_W_V.cwiseAbs().maxCoeff(),
                  std::min(12.0, c.inputs.limits.voltage_V));
        ASSERT_EQ(result.active_limits.holds_force(), result.force_share < 1.0);
        if (result.active_limits.holds_force() && !result.active_limits.voltage) {
            // The limit that is named is the one that is reached.
            const ForceLimit by = result.active_limits.force;
            const double reached =
                by == ForceLimit::tip_force
                    ? force_N(c, current_A) / c.inputs.limits.tip_force_N
                    : std::abs(current_A[static_cast<Eigen::Index>(by) - 2]) / min_A;
            ASSERT_NEAR(reached, kLimiterShare, 1e-9) << static_cast<int>(by);
            ++by_limit.at(static_cast<std::size_t>(by));
        }
        ASSERT_GE(result.force_share, 0.0);
        (result.active_limits.holds_force() ? drawn_back : let_be) += 1;
    }
    EXPECT_GT(drawn_back, 1000);
    EXPECT_GT(let_be, 1000);
    for (std::size_t by = 1; by <= 4; ++by) {
        EXPECT_GT(by_limit.at(by), 50) << kForceLimitNames.at(by);
    }
}

TEST_F(CommandLimiter, EqualWindingsStayWithinTheLimitThroughoutTheTransient) {
    // i(t) = i_s + (i₀ − i_s) e^(−t dR/L) from any currents within the limit.
    for (int run = 0; run < 5000; ++run) {
        const Case c = any_case(devices[static_cast<std::size_t>(run % 2)]);
        const device::DeviceCommand command = limited(c.device, c.requested, c.inputs).command;
        const Vector3 end_A = steady_current_A(c, command);
        const double limit_N = kLimiterShare * c.inputs.limits.tip_force_N;
        Vector3 start_A = testing::random_vector(random, 5.5);
        start_A *= std::min(1.0, limit_N / force_N(c, start_A));
        const double rate_per_s = residual_Ohm(c.device, command.cancelled_resistance_Ohm)[0] /
                                  c.device.motor[0].inductance_H;
        for (int step = 0; step < 30; ++step) {
            const double time_s = 1e-6 * std::pow(1.5, step); // to 0.1 s
            const Vector3 current_A = end_A + (start_A - end_A) * std::exp(-time_s * rate_per_s);
            ASSERT_LE(force_N(c, current_A), limit_N * (1 + 1e-9)) << run << ' ' << time_s;
        }
    }
}

TEST_F(CommandLimiter, WindingsOfUnequalTemperatureExceedTheShareOnlySlightly) {
    // The guard allows a warm winding a larger R̂ than a cold one, so time constants differ and the
    // path from rest is curved. The margin of kLimiterShare covers this: the limit itself is
    // exceeded by at most a tenth, and very rarely.
    double worst = 0.0;
    int ways_beyond = 0;
    constexpr int kWays = 20'000;
    for (int run = 0; run < kWays; ++run) {
        Case c = any_case(devices[0]);
        c.inputs.ramp = 1.0;
        for (double &limit_Ohm : c.inputs.R_hat_limit_Ohm) {
            limit_Ohm += any(0.0, 0.12);
        }
        const device::DeviceCommand command = limited(c.device, c.requested, c.inputs).command;
        const Vector3 dR_Ohm = residual_Ohm(c.device, command.cancelled_resistance_Ohm);
        const Vector3 end_A = steady_current_A(c, command);
        double maximum = 0.0;
        for (int step = 0; step < 28; ++step) {
            const double time_s = 1e-5 * std::pow(1.4, step); // to 0.1 s
            const Vector3 left = (-time_s / c.device.motor[0].inductance_H * dR_Ohm).array().exp();
            maximum = std::max(maximum, force_N(c, end_A - end_A.cwiseProduct(left)) /
                                            c.inputs.limits.tip_force_N);
        }
        worst = std::max(worst, maximum);
        ways_beyond += maximum > 1.0 ? 1 : 0;
    }
    EXPECT_GT(worst, kLimiterShare + 1e-6); // not vacuous
    EXPECT_LT(worst, 1.1);
    EXPECT_LT(ways_beyond, kWays / 1000);
    RecordProperty("worst_share_of_limit", std::to_string(worst));
    RecordProperty("ways_beyond", ways_beyond);
}

TEST_F(CommandLimiter, CommandsWithinLimitsPassBitForBit) {
    int passed = 0;
    int active_limits = 0;
    for (int run = 0; run < 20'000; ++run) {
        Case c = any_case(devices[static_cast<std::size_t>(run % 2)]);
        c.inputs.ramp = 1.0;
        c.requested.cancelled_resistance_Ohm = testing::random_vector(random, 1.0).cwiseAbs();
        const LimitedCommand result = limited(c.device, c.requested, c.inputs);
        const Vector3 current_A = steady_current_A(c, c.requested);
        const Vector3 q_rad = device::joint_from_motor(c.device.geometry, c.inputs.now.theta_rad);
        const device::JointLimits within = within_edge(c.device);
        const double share = std::max(
            {force_N(c, current_A) / (kLimiterShare * c.inputs.limits.tip_force_N),
             current_A.cwiseAbs().maxCoeff() /
                 (kLimiterShare * std::min(5.5, c.inputs.limits.current_A)),
             c.requested.e_W_V.cwiseAbs().maxCoeff() / std::min(12.0, c.inputs.limits.voltage_V)});
        if (!within.allow(q_rad)) {
            continue;
        }
        ASSERT_FALSE(result.active_limits.at_edge);
        if (share < 0.999) {
            ++passed;
            ASSERT_EQ(result.command.e_W_V, c.requested.e_W_V);
            ASSERT_EQ(result.command.cancelled_resistance_Ohm,
                      c.requested.cancelled_resistance_Ohm);
            ASSERT_EQ(result.force_share, 1.0);
            ASSERT_FALSE(result.active_limits.holds_force() || result.active_limits.voltage);
        } else if (share > 1.001) {
            ++active_limits;
            ASSERT_TRUE(result.active_limits.holds_force() || result.active_limits.voltage);
        }
    }
    EXPECT_GT(active_limits, 1000);
    EXPECT_GT(passed, 1000);
}

TEST_F(CommandLimiter, OffsetsOfTheSensorsMakeNoCurrent) {
    for (int run = 0; run < 5000; ++run) {
        Case c = any_observed_case(devices[static_cast<std::size_t>(run % 2)]);
        c.inputs.limits = limits_of(c.device);
        c.requested.e_W_V = testing::random_vector(random, 0.3);
        const LimitedCommand result = limited(c.device, c.requested, c.inputs);
        if (result.active_limits.holds_force() || result.active_limits.voltage) {
            continue;
        }
        Case ideal = c;
        for (control::ObservedMotor &motor : ideal.inputs.motors) {
            motor.offset_A = 0.0;
        }
        const device::DeviceCommand expected = limited(c.device, c.requested, ideal.inputs).command;
        const Vector3 difference_A =
            steady_current_A(c, result.command) - steady_current_A(ideal, expected);
        ASSERT_LT(difference_A.norm(), 1e-12) << run; // round-off of a volt by 0.01 Ω
    }
}

TEST_F(CommandLimiter, ALimitedForceKeepsItsDirection) {
    Case c = any_case(devices[0]);
    c.inputs.now = at(c.device, Vector3(0.1, 0.2, 0.1));
    c.inputs.limits = limits_of(c.device);
    c.inputs.limits.tip_force_N = 1.0;
    c.inputs.ramp = 1.0;
    c.requested = {Vector3(3.0, -2.0, 4.0), Vector3::Constant(1.6)};
    const LimitedCommand result = limited(c.device, c.requested, c.inputs);
    ASSERT_LT(result.force_share, 1.0);
    const Vector3 requested_A = steady_current_A(c, c.requested);
    const Vector3 given_A = steady_current_A(c, result.command);
    EXPECT_LT((given_A - result.force_share * requested_A).norm(), 1e-12);
    EXPECT_NEAR(force_N(c, given_A), kLimiterShare, 1e-12);
}

TEST_F(CommandLimiter, RHatStaysBetweenZeroAndItsLimit) {
    for (int run = 0; run < 5000; ++run) {
        Case c = any_case(devices[0]);
        c.inputs.R_hat_limit_Ohm = testing::random_vector(random, 2.5).cwiseAbs();
        c.requested.cancelled_resistance_Ohm = testing::random_vector(random, 3.0);
        const Vector3 R_hat_Ohm =
            limited(c.device, c.requested, c.inputs).command.cancelled_resistance_Ohm;
        for (Eigen::Index j = 0; j < 3; ++j) {
            ASSERT_GE(R_hat_Ohm[j], 0.0);
            ASSERT_LE(R_hat_Ohm[j], c.inputs.R_hat_limit_Ohm[j]);
            const double ramped_Ohm = c.inputs.ramp * c.requested.cancelled_resistance_Ohm[j];
            if (ramped_Ohm >= 0.0 && ramped_Ohm <= c.inputs.R_hat_limit_Ohm[j]) {
                ASSERT_EQ(R_hat_Ohm[j], ramped_Ohm);
            }
        }
    }
}

TEST_F(CommandLimiter, TheRampScalesTheCommand) {
    Case c = any_case(devices[0]);
    c.inputs.now = at(c.device, Vector3(0.1, 0.2, 0.1));
    c.inputs.limits = limits_of(c.device);
    c.requested = {Vector3(0.3, -0.2, 0.1), Vector3::Constant(1.5)};
    c.inputs.ramp = 0.0;
    EXPECT_EQ(limited(c.device, c.requested, c.inputs).command.e_W_V, Vector3::Zero());
    c.inputs.ramp = 0.5;
    const device::DeviceCommand half = limited(c.device, c.requested, c.inputs).command;
    EXPECT_EQ(half.e_W_V, 0.5 * c.requested.e_W_V);
    EXPECT_EQ(half.cancelled_resistance_Ohm, 0.5 * c.requested.cancelled_resistance_Ohm);
}

TEST_F(CommandLimiter, TheEdgeActsWithAnyTuning) {
    // The soft wall's torque acts at the joint: k_T e_W/dR N equals that of its spring.
    const device::DeviceDescription &device = devices[0];
    const double beyond_rad = 0.01;
    const double q1_rad = device.joint_limits.max_rad[0] - device.edge.margin_rad + beyond_rad;
    for (const double R_hat_Ohm : {0.0, 1.0, 2.0}) {
        Case c = any_case(device);
        c.inputs.now = at(device, Vector3(q1_rad, 0.2, 0.1));
        c.inputs.motors = control::motors_of_file(device.motor);
        c.inputs.limits = limits_of(device);
        c.inputs.ramp = 1.0;
        c.requested = {Vector3::Zero(), Vector3::Constant(R_hat_Ohm)};
        const LimitedCommand result = limited(device, c.requested, c.inputs);
        EXPECT_TRUE(result.active_limits.at_edge);
        const Vector3 torque_Nm =
            device.motor[0].torque_constant_Nm_per_A *
            steady_current_A(c, result.command).cwiseProduct(device.geometry.transmission_ratio);
        EXPECT_NEAR(torque_Nm[0], -device.edge.stiffness_Nm_per_rad * beyond_rad, 1e-12);
        EXPECT_EQ(torque_Nm[1], 0.0);
    }
}

TEST_F(CommandLimiter, ASingularLinkageGetsNoForce) {
    Case c = any_case(devices[0]);
    c.inputs.now = at(c.device, Vector3(0.0, 0.0, 0.0));
    c.inputs.now.J.col(1).setZero();
    c.inputs.now.theta_rate_rad_per_s = Vector3(10.0, -5.0, 2.0);
    c.inputs.ramp = 1.0;
    c.requested = {Vector3(1.0, 2.0, -1.0), Vector3::Constant(1.5)};
    const LimitedCommand result = limited(c.device, c.requested, c.inputs);
    EXPECT_EQ(result.force_share, 0.0);
    EXPECT_TRUE(result.command.e_W_V.allFinite());
    EXPECT_LT(steady_current_A(c, result.command).norm(), 1e-12);
}

/// How far `value` is outside [lowest, highest], without a sign.
double outside(double value, double minimum, double maximum) {
    return std::max({0.0, minimum - value, value - maximum});
}

/// ½ K for each of the three joints and the fold, squared.
double potential_J(const device::DeviceDescription &device, const Vector3 &q_rad) {
    const device::JointLimits &limits = device.joint_limits;
    const double margin_rad = device.edge.margin_rad;
    double sum = 0.0;
    for (Eigen::Index j = 0; j < 3; ++j) {
        const double over_rad =
            outside(q_rad[j], limits.min_rad[j] + margin_rad, limits.max_rad[j] - margin_rad);
        sum += over_rad * over_rad;
    }
    const double over_rad = outside(q_rad[2] - q_rad[1], limits.min_q3_minus_q2_rad + margin_rad,
                                    limits.max_q3_minus_q2_rad - margin_rad);
    return 0.5 * device.edge.stiffness_Nm_per_rad * (sum + over_rad * over_rad);
}

/// Over all angles and beyond, the stops among them.
Vector3 any_angles(std::mt19937_64 &random) {
    return Vector3(0.0, 0.0, 1.6) + testing::random_vector(random, 2.4);
}

class WorkspaceEdgeTest : public ::testing::Test {
protected:
    [[nodiscard]] Vector3 torque_Nm(const Vector3 &q_rad,
                                    const Vector3 &rate_rad_per_s = Vector3::Zero()) const {
        return edge_torque_Nm(device, q_rad, rate_rad_per_s);
    }

    device::DeviceDescription device = testing::phantom_1_0();
    std::mt19937_64 random{2};
};

TEST_F(WorkspaceEdgeTest, AtRestItIsTheGradientOfAPotential) {
    constexpr double kStep_rad = 1e-6;
    int at_edge = 0;
    for (int run = 0; run < 5000; ++run) {
        const Vector3 q_rad = any_angles(random);
        Vector3 gradient_Nm;
        for (Eigen::Index j = 0; j < 3; ++j) {
            const Vector3 step_rad = kStep_rad * Vector3::Unit(j);
            gradient_Nm[j] =
                (potential_J(device, q_rad + step_rad) - potential_J(device, q_rad - step_rad)) /
                (2.0 * kStep_rad);
        }
        const Vector3 found_Nm = torque_Nm(q_rad);
        ASSERT_LT((found_Nm + gradient_Nm).norm(), 1e-5) << q_rad.transpose();
        at_edge += found_Nm.isZero(0.0) ? 0 : 1;
    }
    EXPECT_GT(at_edge, 500);
    EXPECT_LT(at_edge, 4900);
}

TEST_F(WorkspaceEdgeTest, IsZeroWithinAtAnySpeed) {
    const device::JointLimits within = within_edge(device);
    int tried = 0;
    for (int run = 0; run < 20'000; ++run) {
        const Vector3 q_rad = any_angles(random);
        if (within.allow(q_rad)) {
            ++tried;
            ASSERT_TRUE(torque_Nm(q_rad, testing::random_vector(random, 50.0)).isZero(0.0));
            ASSERT_EQ(
                beyond_limits(device.joint_limits, q_rad, device.edge.margin_rad).max_excess_rad(),
                0.0);
        }
    }
    EXPECT_GT(tried, 500);
}

TEST_F(WorkspaceEdgeTest, OnlyPushesBack) {
    // Each joint alone, at any speed: its torque points inwards or is zero; when moving outwards it
    // is larger than at rest, when moving back smaller.
    const Vector3 middle_rad(0.0, 0.3, 0.3);
    for (const Eigen::Index j : {0, 1, 2}) {
        for (const double sign : {-1.0, 1.0}) {
            Vector3 q_rad = middle_rad;
            const double margin_rad = device.edge.margin_rad;
            const double edge_rad = sign > 0.0 ? device.joint_limits.max_rad[j] - margin_rad
                                               : device.joint_limits.min_rad[j] + margin_rad;
            q_rad[j] = edge_rad + sign * 0.02;
            if (j == 1) {
                q_rad[2] = q_rad[1]; // not folded
            } else if (j == 2) {
                q_rad[1] = q_rad[2];
            }
            const double rest_Nm = torque_Nm(q_rad)[j];
            EXPECT_NEAR(rest_Nm, -sign * 0.02 * device.edge.stiffness_Nm_per_rad, 1e-12);
            for (int run = 0; run < 100; ++run) {
                const Vector3 rate = testing::random_vector(random, 10.0);
                Vector3 alone = Vector3::Zero();
                alone[j] = rate[j];
                const double found_Nm = torque_Nm(q_rad, alone)[j];
                ASSERT_LE(sign * found_Nm, 0.0);
                ASSERT_NEAR(found_Nm,
                            sign * std::min(0.0, sign * (rest_Nm - device.edge.damping_Nms_per_rad *
                                                                       rate[j])),
                            1e-12);
            }
        }
    }
}

TEST_F(WorkspaceEdgeTest, TheFoldPushesBothLinksEqually) {
    for (const double sign : {-1.0, 1.0}) {
        const double edge_rad =
            sign > 0.0 ? device.joint_limits.max_q3_minus_q2_rad - device.edge.margin_rad
                       : device.joint_limits.min_q3_minus_q2_rad + device.edge.margin_rad;
        const Vector3 q_rad(0.0, 1.0, 1.0 + edge_rad + sign * 0.01);
        const Vector3 found_Nm = torque_Nm(q_rad);
        EXPECT_EQ(found_Nm[0], 0.0);
        EXPECT_NEAR(found_Nm[2], -sign * 0.01 * device.edge.stiffness_Nm_per_rad, 1e-12);
        EXPECT_EQ(found_Nm[1], -found_Nm[2]);
        // Turning both links together is not folding; further folding is opposed.
        EXPECT_EQ(torque_Nm(q_rad, Vector3(0.0, 3.0, 3.0)), found_Nm);
        EXPECT_LT(sign * torque_Nm(q_rad, Vector3(0.0, 0.0, sign))[2], sign * found_Nm[2]);
    }
}

TEST_F(WorkspaceEdgeTest, IsPassive) {
    // On a closed path through the wall at any speed the wall absorbs energy: −∮ τ·dq ≥ 0.
    for (int run = 0; run < 50; ++run) {
        const Vector3 centre_rad = any_angles(random);
        const Vector3 a_rad = testing::random_vector(random, 0.5);
        const Vector3 b_rad = testing::random_vector(random, 0.5);
        const double speed_rad_per_s = 6.0;
        constexpr int kSteps = 20'000;
        const double step = 2.0 * 3.141592653589793 / kSteps;
        double taken_J = 0.0;
        for (int i = 0; i < kSteps; ++i) {
            const double phase = (i + 0.5) * step;
            const Vector3 q_rad = centre_rad + std::cos(phase) * a_rad + std::sin(phase) * b_rad;
            const Vector3 slope = -std::sin(phase) * a_rad + std::cos(phase) * b_rad;
            taken_J -= torque_Nm(q_rad, speed_rad_per_s * slope).dot(slope) * step;
        }
        ASSERT_GT(taken_J, -1e-6) << run;
    }
}

TEST_F(WorkspaceEdgeTest, BeyondLimitsHasTheSignOfTheSide) {
    const device::JointLimits &limits = device.joint_limits;
    const BeyondLimits low = beyond_limits(limits, limits.min_rad - Vector3(0.1, 0.2, 0.3), 0.0);
    EXPECT_LT((low.joint_rad + Vector3(0.1, 0.2, 0.3)).norm(), 1e-12);
    const BeyondLimits high = beyond_limits(limits, limits.max_rad + Vector3(0.1, 0.2, 0.3), 0.0);
    EXPECT_LT((high.joint_rad - Vector3(0.1, 0.2, 0.3)).norm(), 1e-12);
    const Vector3 folded(0.0, 0.8, 0.8 + limits.min_q3_minus_q2_rad - 0.05);
    EXPECT_NEAR(beyond_limits(limits, folded, 0.0).fold_rad, -0.05, 1e-12);
    EXPECT_NEAR(beyond_limits(limits, folded, 0.0).max_excess_rad(), 0.05, 1e-12);
}

} // namespace
} // namespace springdrive::servo
