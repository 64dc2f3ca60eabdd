// Covers device/core/motor/winding_heat.cpp.
#include "device/core/motor/winding_heat.h"

#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace springdrive::device {
namespace {

ThermalParameters thermal() { return testing::phantom_motor().thermal; }

/// The two heat balances of the header, by classical Runge-Kutta.
struct Network {
    ThermalParameters t = thermal();
    double ambient_C = 25.0;
    double heat_W = 0.0;
    double winding_C = 25.0;
    double housing_C = 25.0;

    struct Rate {
        double winding;
        double housing;
    };
    [[nodiscard]] Rate rate(double w_C, double h_C) const {
        const double inner_W = (w_C - h_C) / t.winding_housing_K_per_W;
        const double outer_W = (h_C - ambient_C) / t.housing_ambient_K_per_W;
        return {(heat_W - inner_W) / (t.winding_time_s / t.winding_housing_K_per_W),
                (inner_W - outer_W) / (t.motor_time_s / t.housing_ambient_K_per_W)};
    }
    void advance(double seconds, int steps) {
        const double h = seconds / steps;
        for (int i = 0; i < steps; ++i) {
            const Rate a = rate(winding_C, housing_C);
            const Rate b = rate(winding_C + 0.5 * h * a.winding, housing_C + 0.5 * h * a.housing);
            const Rate c = rate(winding_C + 0.5 * h * b.winding, housing_C + 0.5 * h * b.housing);
            const Rate d = rate(winding_C + h * c.winding, housing_C + h * c.housing);
            winding_C += h / 6.0 * (a.winding + 2.0 * b.winding + 2.0 * c.winding + d.winding);
            housing_C += h / 6.0 * (a.housing + 2.0 * b.housing + 2.0 * c.housing + d.housing);
        }
    }
};

TEST(WindingTemperature, AgreesWithAnIntegration) {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> heat_W(0.0, 30.0);
    for (const double period_s : {1e-3, 0.1, 5.0, 60.0}) {
        WindingTemperature exact(thermal(), 20.0, period_s);
        Network reference{thermal(), 20.0, 0.0, 20.0, 20.0};
        for (int i = 0; i < 50; ++i) {
            reference.heat_W = heat_W(random);
            exact.update(reference.heat_W);
            // h/t_w stays below 1/240, and the error (h/t_w)^5/120 per step is below 1e-14 of 100
            // K.
            reference.advance(period_s, std::max(1, static_cast<int>(20 * period_s)));
            ASSERT_NEAR(exact.winding_C(), reference.winding_C, 1e-9) << "T " << period_s;
            ASSERT_NEAR(exact.housing_C(), reference.housing_C, 1e-9) << "T " << period_s;
        }
    }
}

TEST(WindingTemperature, SettlesAtTheTemperatureOfItsThermalResistances) {
    const ThermalParameters t = thermal();
    constexpr double kHeat_W = 3.0;
    WindingTemperature winding(t, 22.0, 10.0);
    for (int i = 0; i < 3000; ++i) { // 49 time constants: e^-49 of 51 K remains
        winding.update(kHeat_W);
    }
    EXPECT_NEAR(winding.housing_C(), 22.0 + kHeat_W * t.housing_ambient_K_per_W, 1e-10);
    EXPECT_NEAR(winding.winding_C(),
                22.0 + kHeat_W * (t.winding_housing_K_per_W + t.housing_ambient_K_per_W), 1e-10);
}

TEST(WindingTemperature, ConservesEnergy) {
    // The supplied heat is in winding and housing, or went to the air: ∫ (T_h − T_a)/R_ha dt, which
    // Simpson's rule computes from three values per pair of periods to (T/t_w)⁴/180.
    const ThermalParameters t = thermal();
    constexpr double kPeriod_s = 0.05;
    constexpr double kHeat_W = 8.0;
    WindingTemperature winding(t, 25.0, kPeriod_s);
    double to_the_air_J = 0.0;
    const auto outflow_W = [&] { return (winding.housing_C() - 25.0) / t.housing_ambient_K_per_W; };
    for (int pair = 0; pair < 1000; ++pair) {
        to_the_air_J += kPeriod_s / 3.0 * outflow_W();
        winding.update(kHeat_W);
        to_the_air_J += 4.0 * kPeriod_s / 3.0 * outflow_W();
        winding.update(kHeat_W);
        to_the_air_J += kPeriod_s / 3.0 * outflow_W();
    }
    const double held_J =
        (winding.winding_C() - 25.0) * t.winding_time_s / t.winding_housing_K_per_W +
        (winding.housing_C() - 25.0) * t.motor_time_s / t.housing_ambient_K_per_W;
    EXPECT_GT(to_the_air_J, 10.0); // not vacuous
    EXPECT_NEAR(held_J + to_the_air_J, 2000 * kPeriod_s * kHeat_W, 1e-9 * held_J);
}

TEST(WindingTemperature, WarmsWithItsTimeConstantAtAFixedHousingTemperature) {
    // The housing's temperature is fixed by a very large heat capacity, as in the definition of t_w
    // in data sheets.
    ThermalParameters t = thermal();
    t.motor_time_s = 1e12;
    WindingTemperature winding(t, 25.0, t.winding_time_s);
    constexpr double kHeat_W = 20.0;
    winding.update(kHeat_W);
    // It warms by P t_w / C_h, below 1e-8 °C.
    EXPECT_NEAR(winding.winding_C(),
                25.0 + kHeat_W * t.winding_housing_K_per_W * (1.0 - 1.0 / std::numbers::e), 1e-7);
}

TEST(WindingTemperature, IsIndependentOfTheSubdivisionOfAPeriod) {
    WindingTemperature whole(thermal(), 25.0, 30.0);
    WindingTemperature split(thermal(), 25.0, 30.0 / 4096);
    whole.update(12.0);
    for (int i = 0; i < 4096; ++i) {
        split.update(12.0);
    }
    // Round-off of 4096 steps on 50 °C.
    EXPECT_NEAR(whole.winding_C(), split.winding_C(), 1e-10);
    EXPECT_NEAR(whole.housing_C(), split.housing_C(), 1e-10);
}

TEST(WindingTemperature, MoreHeatAndWarmerAirNeverCool) {
    // The basis of WindingGuard's bounds.
    std::mt19937 random(2);
    std::uniform_real_distribution<double> share(0.0, 1.0);
    for (int run = 0; run < 100; ++run) {
        const double air_C = 10.0 + 20.0 * share(random);
        WindingTemperature less(thermal(), air_C, 1e-2);
        WindingTemperature more(thermal(), air_C + 20.0 * share(random), 1e-2);
        for (int i = 0; i < 500; ++i) {
            const double heat_W = 40.0 * share(random);
            less.update(heat_W * share(random));
            more.update(heat_W);
            ASSERT_LE(less.winding_C(), more.winding_C());
            ASSERT_LE(less.housing_C(), more.housing_C());
        }
    }
}

TEST(WindingResistance, RisesAsCopperAndRipplesWithTheCommutator) {
    const MotorParameters m = testing::phantom_motor();
    const double R = m.resistance_Ohm;
    const double quarter_rad = 0.5 * std::numbers::pi / m.commutator_segments;
    EXPECT_NEAR(winding_resistance_Ohm(m, 25.0, quarter_rad), R, 1e-14);
    EXPECT_NEAR(winding_resistance_Ohm(m, 75.0, quarter_rad), 1.195 * R, 1e-14);
    EXPECT_NEAR(winding_resistance_Ohm(m, 15.0, quarter_rad), 0.961 * R, 1e-14);
    EXPECT_NEAR(winding_resistance_Ohm(m, 25.0, 0.0), 1.02 * R, 1e-14);
    EXPECT_NEAR(winding_resistance_Ohm(m, 25.0, 2.0 * quarter_rad), 0.98 * R, 1e-14);
    // A turn of the rotor has as many ripples as segments.
    const double a_segment_rad = 2.0 * std::numbers::pi / m.commutator_segments;
    EXPECT_NEAR(winding_resistance_Ohm(m, 60.0, 0.3),
                winding_resistance_Ohm(m, 60.0, 0.3 + a_segment_rad), 1e-14);
}

TEST(WindingResistance, BoundsAreTheExtremesOverATurn) {
    const MotorParameters m = testing::phantom_motor();
    for (const double winding_C : {15.0, 25.0, 60.0, 100.0}) {
        double min_Ohm = INFINITY;
        double max_Ohm = 0.0;
        constexpr int kAngles = 11 * 200;
        for (int i = 0; i < kAngles; ++i) {
            const double R_Ohm =
                winding_resistance_Ohm(m, winding_C, 2.0 * std::numbers::pi * i / kAngles);
            min_Ohm = std::min(min_Ohm, R_Ohm);
            max_Ohm = std::max(max_Ohm, R_Ohm);
        }
        EXPECT_NEAR(min_resistance_Ohm(m, winding_C), min_Ohm, 1e-14);
        EXPECT_NEAR(max_resistance_Ohm(m, winding_C), max_Ohm, 1e-14);
    }
}

} // namespace
} // namespace springdrive::device
