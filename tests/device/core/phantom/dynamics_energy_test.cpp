// Covers device/core/phantom/dynamics.cpp against CVODE.
#include "device/core/phantom/dynamics.h"

#include "tests/support/configurations.h"
#include "tests/support/cvode.h"
#include "tests/support/devices.h"

#include <Eigen/LU>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace springdrive::device {
namespace {

using Eigen::VectorXd;

TEST(Cvode, IsAccurateEnoughAsAReference) {
    // A pendulum's closed form would need elliptic functions; ẏ = −y² has y = 1/(1 + t), and an
    // oscillator of 100 rad/s its sine. A hundred radians of steps at 1e-12 each.
    const VectorXd end = testing::integrate(
        [](double, const VectorXd &y) -> VectorXd {
            return Vector3(-y[0] * y[0], y[2], -1e4 * y[1]);
        },
        Vector3(1.0, 0.0, 100.0), 1.0);
    EXPECT_NEAR(end[0], 0.5, 1e-11);
    EXPECT_NEAR(end[1], std::sin(100.0), 1e-9);
}

/// Torques at the joints, smooth and different on each.
struct RandomTorques {
    explicit RandomTorques(std::mt19937_64 &random) {
        for (int j = 0; j < 3; ++j) {
            amplitude_Nm.col(j) = testing::random_vector(random, 0.05);
            frequency.col(j) = testing::random_vector(random, 40.0);
        }
    }
    [[nodiscard]] Vector3 at(double time_s) const {
        return (amplitude_Nm.array() * (frequency.array() * time_s).sin()).matrix().rowwise().sum();
    }

    Matrix3 amplitude_Nm{Matrix3::Zero()};
    Matrix3 frequency{Matrix3::Zero()}; ///< rad/s
};

TEST(DynamicsAgainstCvode, EnergyGrowsByTheWorkOfTheTorques) {
    // M q̈ + C q̇ + g = τ(t) together with Ẇ = τᵀ q̇: they agree only if the equations share one
    // energy.
    std::mt19937_64 random(61);
    for (int run = 0; run < 20; ++run) {
        const DeviceDescription device =
            run % 2 == 0 ? testing::phantom_1_0() : testing::phantom_premium_1_5();
        const LinkageMoments m = linkage_moments(device.geometry, device.inertia, 0.05);
        const RandomTorques torques(random);
        const auto rates = [&](double time_s, const VectorXd &y) {
            const Vector3 q = y.head<3>();
            const Vector3 w = y.segment<3>(3);
            const Vector3 torque_Nm = torques.at(time_s);
            VectorXd y_rate(7);
            y_rate << w,
                mass_matrix(m, q).inverse() *
                    (torque_Nm - coriolis_torque_Nm(m, q, w) - gravity_torque_Nm(m, q)),
                torque_Nm.dot(w);
            return y_rate;
        };
        const auto energy_J = [&](const VectorXd &y) {
            const Vector3 w = y.segment<3>(3);
            return 0.5 * w.dot(mass_matrix(m, y.head<3>()) * w) + gravity_energy_J(m, y.head<3>());
        };
        VectorXd start(7);
        start << testing::random_workspace_angles(device, random),
            testing::random_vector(random, 2.0), 0.0;
        const VectorXd end = testing::integrate(rates, start, 0.5);
        const double work_J = end[6];
        ASSERT_GT(std::abs(work_J), 1e-4); // not vacuous
        EXPECT_NEAR((energy_J(end) - energy_J(start)) / work_J, 1.0, 1e-8) << "run " << run;
    }
}

} // namespace
} // namespace springdrive::device
