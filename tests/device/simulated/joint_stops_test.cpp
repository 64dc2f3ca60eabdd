// Covers device/simulated/linkage_step.cpp.
#include "device/simulated/linkage_step.h"

#include "tests/support/configurations.h"
#include "tests/support/devices.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

namespace springdrive::simulated {
namespace {

const device::JointLimits &limits() {
    static const device::JointLimits read = testing::phantom_1_0().joint_limits;
    return read;
}

/// Angles in and beyond the joints' travel.
Vector3 random_angles(std::mt19937_64 &random) {
    return 0.5 * (limits().min_rad + limits().max_rad) + testing::random_vector(random, 2.5);
}

bool is_inside(const Vector3 &q) {
    const double fold = q[2] - q[1];
    return (q.array() <= limits().max_rad.array()).all() &&
           (q.array() >= limits().min_rad.array()).all() && fold <= limits().max_q3_minus_q2_rad &&
           fold >= limits().min_q3_minus_q2_rad;
}

TEST(JointStops, DoWorkEqualToTheirEnergyChange) {
    std::mt19937_64 random(31);
    int pressed = 0;
    for (int i = 0; i < 10'000; ++i) {
        const Vector3 q_a = random_angles(random);
        // Large and small steps, down to that of a joint at rest.
        const Vector3 q_b = q_a + std::pow(10.0, -(i % 12)) * testing::random_vector(random, 1.0);
        const StopTorque stop = stop_torque(limits(), q_a, q_b);
        const double before_J = stop_energy_J(limits(), q_a);
        const double after_J = stop_energy_J(limits(), q_b);
        pressed += before_J > 0.0 ? 1 : 0;
        // Round-off of energies of up to some hundred joules.
        ASSERT_NEAR(stop.torque_Nm.dot(q_b - q_a), before_J - after_J,
                    1e-14 * (before_J + after_J + 1.0));
        ASSERT_GE(Eigen::SelfAdjointEigenSolver<Matrix3>(stop.damping_Nms_per_rad)
                      .eigenvalues()
                      .minCoeff(),
                  -1e-16);
        ASSERT_TRUE(before_J > 0.0 || stop.damping_Nms_per_rad.isZero(0.0));
    }
    EXPECT_GT(pressed, 1000);
    EXPECT_LT(pressed, 9900);
}

TEST(JointStops, AreInactiveInside) {
    std::mt19937_64 random(32);
    int inside = 0;
    while (inside < 1000) {
        const Vector3 q_a = random_angles(random);
        const Vector3 q_b = random_angles(random);
        if (!is_inside(q_a) || !is_inside(q_b)) {
            continue;
        }
        ++inside;
        const StopTorque stop = stop_torque(limits(), q_a, q_b);
        ASSERT_EQ(stop.torque_Nm, Vector3::Zero());
        ASSERT_EQ(stop.damping_Nms_per_rad, Matrix3::Zero());
        ASSERT_EQ(stop_energy_J(limits(), q_a), 0.0);
    }
}

TEST(JointStops, PressBackBeyondEachOfTheEightLimits) {
    const double fold_rad = 0.5;
    const device::JointLimits box{Vector3::Constant(-1.0), Vector3::Constant(1.0), -fold_rad,
                                  fold_rad};
    struct Line {
        Vector3 at_rad;
        Vector3 outwards;
    };
    const std::array<Line, 8> lines{{
        {Vector3(1.0, 0.0, 0.0), Vector3::UnitX()},
        {Vector3(-1.0, 0.0, 0.0), -Vector3::UnitX()},
        {Vector3(0.0, 1.0, 0.8), Vector3::UnitY()},
        {Vector3(0.0, -1.0, -0.8), -Vector3::UnitY()},
        {Vector3(0.0, 0.8, 1.0), Vector3::UnitZ()},
        {Vector3(0.0, -0.8, -1.0), -Vector3::UnitZ()},
        {Vector3(0.0, 0.0, fold_rad), Vector3(0.0, -1.0, 1.0)},
        {Vector3(0.0, 0.0, -fold_rad), Vector3(0.0, 1.0, -1.0)},
    }};
    constexpr double kBeyond_rad = 1e-6;
    for (const Line &line : lines) {
        const Vector3 out = line.at_rad + kBeyond_rad * line.outwards;
        const Vector3 in = line.at_rad - kBeyond_rad * line.outwards;
        const Vector3 torque_Nm = stop_torque(box, out, out).torque_Nm;
        EXPECT_LT(torque_Nm.dot(line.outwards), 0.0);
        EXPECT_LT(torque_Nm.cross(line.outwards).norm(), 1e-15); // exactly opposed to it
        EXPECT_EQ(stop_torque(box, in, in).torque_Nm, Vector3::Zero());
    }
}

} // namespace
} // namespace springdrive::simulated
