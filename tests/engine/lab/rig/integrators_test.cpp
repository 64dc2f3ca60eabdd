// Covers engine/lab/rig/integrators.h.
#include "engine/lab/rig/integrators.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <optional>

namespace springdrive::rig {
namespace {

using Scalar = Eigen::Matrix<double, 1, 1>;
using Pair = Eigen::Vector2d;

constexpr double kRoundOff = 20.0 * std::numeric_limits<double>::epsilon();

/// ẏ = λ y.
auto decay(double lambda) {
    return [lambda](double, const Scalar &y) { return Scalar(lambda * y); };
}

template <typename Rates> double midpoint(const Rates &f, double time_s, double y, double h) {
    ImplicitMidpoint<Scalar> method;
    method.prepare(f, time_s, Scalar(y), h);
    const std::optional<Scalar> next = method.step(f, time_s, Scalar(y));
    return next ? (*next)[0] : std::numeric_limits<double>::quiet_NaN();
}

TEST(Integrators, MultiplyALinearSystemByTheirStabilityFunctions) {
    for (const double z : {-3.0, -1.0, -0.1, 0.5}) {
        const double h = 0.25;
        const auto f = decay(z / h);
        const double euler = explicit_euler_step(f, 0.0, Scalar(1.0), h)[0];
        const double runge_kutta = runge_kutta_step(f, 0.0, Scalar(1.0), h)[0];
        EXPECT_NEAR(euler, 1.0 + z, kRoundOff);
        EXPECT_NEAR(runge_kutta, 1.0 + z * (1.0 + z / 2.0 * (1.0 + z / 3.0 * (1.0 + z / 4.0))),
                    kRoundOff);
        EXPECT_NEAR(midpoint(f, 0.0, 1.0, h), (1.0 + 0.5 * z) / (1.0 - 0.5 * z), kRoundOff);
    }
}

TEST(Integrators, StandUpToTheirStepLimitAndNoFurther) {
    // Where the stability function is ±1: 2 for Euler, 2.785294 for Runge-Kutta.
    const auto grown = [](double z, const auto &step) {
        const auto f = decay(-1.0);
        Scalar y(1.0);
        for (int i = 0; i < 1000; ++i) {
            y = step(f, 0.0, y, z);
        }
        return std::abs(y[0]);
    };
    const auto euler = [](const auto &...given) { return explicit_euler_step(given...); };
    const auto runge_kutta = [](const auto &...given) { return runge_kutta_step(given...); };
    EXPECT_LT(grown(0.99 * 2.0, euler), 1e-6);
    EXPECT_GT(grown(1.01 * 2.0, euler), 1e6);
    EXPECT_LT(grown(0.99 * 2.785294, runge_kutta), 1e-6);
    EXPECT_GT(grown(1.01 * 2.785294, runge_kutta), 1e6);
    // The midpoint method has none.
    EXPECT_LT(std::abs(midpoint(decay(-1e6), 0.0, 1.0, 1.0)), 1.0);
}

TEST(Integrators, MeetAnEquationOfTimeAtTheirOrders) {
    // ẏ = −2 t y² from y(0) = 1 is y = 1/(1 + t²).
    const auto f = [](double t, const Scalar &y) { return Scalar(-2.0 * t * y[0] * y[0]); };
    const auto error = [&](const auto &step, int steps) {
        const double h = 1.0 / steps;
        double y = 1.0;
        for (int i = 0; i < steps; ++i) {
            y = step(i * h, y, h);
        }
        return std::abs(y - 0.5);
    };
    const auto order = [&](const auto &step) {
        return std::log2(error(step, 64) / error(step, 128));
    };
    const auto euler = [&](double t, double y, double h) {
        return explicit_euler_step(f, t, Scalar(y), h)[0];
    };
    const auto runge_kutta = [&](double t, double y, double h) {
        return runge_kutta_step(f, t, Scalar(y), h)[0];
    };
    const auto implicit_midpoint = [&](double t, double y, double h) {
        return midpoint(f, t, y, h);
    };
    EXPECT_NEAR(order(euler), 1.0, 0.1);
    EXPECT_NEAR(order(runge_kutta), 4.0, 0.1);
    EXPECT_NEAR(order(implicit_midpoint), 2.0, 0.1);
}

/// q̇ = p, ṗ = −q.
Pair oscillator(double, const Pair &y) { return {y[1], -y[0]}; }

TEST(SemiImplicitEuler, KeepsTheEnergyThatIsItsOwn) {
    // q² + p² − h q p is constant, whatever h below 2.
    const double h = 0.3;
    const auto kick = [](double, const Pair &y) { return Pair(0.0, -y[0]); };
    const auto drift = [](double, const Pair &y) { return Pair(y[1], 0.0); };
    const auto energy = [h](const Pair &y) { return y.squaredNorm() - h * y[0] * y[1]; };
    Pair y(1.0, 0.2);
    const double start = energy(y);
    for (int i = 0; i < 10'000; ++i) {
        y = semi_implicit_euler_step(kick, drift, 0.0, y, h);
        ASSERT_NEAR(energy(y), start, 1e-12); // round-off, 10,000 times
    }
}

TEST(ImplicitMidpoint, KeepsAnOscillatorsEnergy) {
    ImplicitMidpoint<Pair> method;
    Pair y(1.0, 0.2);
    const double start = y.squaredNorm();
    method.prepare(oscillator, 0.0, y, 0.3);
    for (int i = 0; i < 10'000; ++i) {
        const std::optional<Pair> next = method.step(oscillator, 0.0, y);
        ASSERT_TRUE(next);
        y = *next;
        ASSERT_NEAR(y.squaredNorm(), start, 1e-12); // round-off, 10,000 times
    }
}

TEST(ImplicitMidpoint, SaysWhereItDoesNotSettle) {
    const auto f = [](double, const Scalar &) {
        return Scalar(std::numeric_limits<double>::quiet_NaN());
    };
    EXPECT_TRUE(std::isnan(midpoint(f, 0.0, 1.0, 0.1)));
}

} // namespace
} // namespace springdrive::rig
