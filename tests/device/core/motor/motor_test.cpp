// Covers device/core/motor/motor.cpp.
#include "device/core/motor/motor.h"

#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <cmath>

namespace springdrive::device {
namespace {

/// i' = (u − dR i)/L by a Taylor series of many small steps in extended precision.
struct Reference {
    long double current_A;
    long double mean_A;
};
Reference integrate(const MotorParameters &m, long double dR, long double i0, long double u,
                    long double h) {
    constexpr int kSteps = 2000;
    const long double step = h / kSteps;
    long double i = i0;
    long double sum = 0.0L;
    for (int k = 0; k < kSteps; ++k) {
        // Exact derivatives of a linear equation: each is −dR/L times the previous one.
        long double derivative = (u - dR * i) / m.inductance_H;
        long double power = step;
        long double next = i;
        long double integral = i * step;
        for (int order = 1; order <= 6; ++order) {
            next += derivative * power;
            integral += derivative * power * step / (order + 1);
            derivative *= -dR / m.inductance_H;
            power *= step / (order + 1);
        }
        i = next;
        sum += integral;
    }
    return {i, sum / h};
}

TEST(WindingStep, AgreesWithAnIntegrationForEveryResistance) {
    const MotorParameters m = testing::phantom_motor();
    const double i0 = 0.7;
    const double u = 0.3;
    for (const double dR : {-0.3, -0.02, -1e-6, 0.0, 1e-9, 1e-4, 0.02, 0.094, 0.097, 0.4, 2.18}) {
        for (const double h : {1e-6, 25e-6, 1e-3}) {
            const WindingStep w = winding_step(m, dR, h);
            const Reference truth = integrate(m, dR, i0, u, h);
            const double current = w.decay * i0 + w.gain_A_per_V * u;
            const double mean = w.mean_decay * i0 + w.mean_gain_A_per_V * u;
            // Relative round-off, amplified in φ₂ by at most 1/0.01 where the series takes over.
            EXPECT_NEAR(current, static_cast<double>(truth.current_A), 1e-13 * (1 + current))
                << "dR " << dR << " h " << h;
            EXPECT_NEAR(mean, static_cast<double>(truth.mean_A), 1e-13 * (1 + std::abs(mean)))
                << "dR " << dR << " h " << h;
        }
    }
}

TEST(Motor, DataSheetGivesThePublishedStiffness) {
    // docs/design.md, "Linkage and motors": K_L = 2.30 N·m/rad and R/L = 9160 rad/s, both given to
    // three digits.
    EXPECT_NEAR(inductive_stiffness_Nm_per_rad(testing::phantom_motor()), 2.30, 0.005);
    EXPECT_NEAR(testing::phantom_motor().resistance_Ohm / testing::phantom_motor().inductance_H,
                9160.0, 5.0);
}

TEST(Motor, SpringAndDamperInSeriesHaveTheElectricalCorner) {
    // K_L/B_dR is dR/L: the mechanical analogy of Fig. 1 has the electrical time constant.
    const double dR = 0.37;
    EXPECT_NEAR(inductive_stiffness_Nm_per_rad(testing::phantom_motor()) /
                    series_damping_Nms_per_rad(testing::phantom_motor(), dR),
                dR / testing::phantom_motor().inductance_H, 1e-9);
}

} // namespace
} // namespace springdrive::device
