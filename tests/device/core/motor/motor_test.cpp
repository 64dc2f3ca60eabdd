// Covers device/core/motor/motor.cpp and, of winding_heat.cpp, the temperature.
#include "device/core/motor/motor.h"

#include "device/core/motor/winding_heat.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

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

constexpr double kStep_s = 25e-6;
/// Round-off of currents of some amperes, amplified by the cancellation in a mean over a short
/// step.
constexpr double kRoundOff_A = 1e-12;

/// End and mean of i from L di/dt = V − R i, in closed form.
struct Current {
    double end_A = 0.0;
    double mean_A = 0.0;
};
Current closed_form(double voltage_V, double net_Ohm, double current_A, double step_s = kStep_s) {
    const double time_s = testing::phantom_motor().inductance_H / net_Ohm;
    const double steady_A = voltage_V / net_Ohm;
    const double decay = std::exp(-step_s / time_s);
    return {steady_A + (current_A - steady_A) * decay,
            steady_A + (current_A - steady_A) * (1.0 - decay) * time_s / step_s};
}

void expect_current(const CurrentStep &step, double rate_rad_per_s, const Current &truth) {
    EXPECT_NEAR(step.end_at(rate_rad_per_s), truth.end_A, kRoundOff_A);
    EXPECT_NEAR(step.mean_at(rate_rad_per_s), truth.mean_A, kRoundOff_A);
}

TEST(SpringDrive, IsAWindingOfTheResidualResistanceWithinItsLimits) {
    // (11): L di/dt = e_W − dR i − k_T θ̇, for any rotor velocity.
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> one(-1.0, 1.0);
    for (int i = 0; i < 1000; ++i) {
        const double R_Ohm = 2.18 * (1.0 + 0.3 * one(random));
        const double dR_Ohm = 1.1 + one(random);
        const DriveState now{R_Ohm, 1.5 * one(random), 100.0 * one(random), true};
        const double e_W_V = 3.0 * one(random);
        const double mean_rate = 100.0 * one(random);
        const CurrentStep step =
            spring_drive_step(testing::phantom_motor(), now, e_W_V, R_Ohm - dR_Ohm, kStep_s);
        expect_current(
            step, mean_rate,
            closed_form(e_W_V - testing::phantom_motor().torque_constant_Nm_per_A * mean_rate,
                        dR_Ohm, now.current_A));
    }
}

TEST(SpringDrive, IsLimitedToTheSupplyVoltage) {
    // e_A = R̂ i + e_W on either side of 12 V, and of −12 V.
    const double R_Ohm = testing::phantom_motor().resistance_Ohm;
    const double R_hat_Ohm = 1.7;
    for (const double sign : {1.0, -1.0}) {
        const DriveState now{R_Ohm, sign * 2.0, 0.0, true};
        const auto at = [&](double e_A_V) {
            const double e_W_V = sign * (e_A_V - R_hat_Ohm * 2.0);
            return spring_drive_step(testing::phantom_motor(), now, e_W_V, R_hat_Ohm, kStep_s);
        };
        const double supply_V = testing::phantom_motor().supply_V;
        expect_current(at(0.8 * supply_V), 0.0,
                       closed_form(sign * (0.8 * supply_V - R_hat_Ohm * 2.0), R_Ohm - R_hat_Ohm,
                                   now.current_A));
        // At the supply limit there is no cancellation: the full R, and at most 12 V.
        const Current railed = closed_form(sign * supply_V, R_Ohm, now.current_A);
        expect_current(at(1.001 * supply_V), 0.0, railed);
        expect_current(at(100.0 * supply_V), 0.0, railed);
    }
}

TEST(SpringDrive, ReachesTheSupplyVoltageWithinAStep) {
    // The current grows until R̂ i + e_W reaches the supply; that time has a closed form.
    const double R_Ohm = testing::phantom_motor().resistance_Ohm;
    const double R_hat_Ohm = 1.7;
    const double dR_Ohm = R_Ohm - R_hat_Ohm;
    for (const double share : {0.95, 0.99, 0.999}) {
        const DriveState now{R_Ohm, 2.0, 0.0, true};
        const double e_W_V = share * testing::phantom_motor().supply_V - R_hat_Ohm * now.current_A;
        const double steady_A = e_W_V / dR_Ohm;
        const double rail_A = (testing::phantom_motor().supply_V - e_W_V) / R_hat_Ohm;
        const double free_s = testing::phantom_motor().inductance_H / dR_Ohm *
                              std::log((now.current_A - steady_A) / (rail_A - steady_A));
        ASSERT_GT(free_s, 0.0);
        ASSERT_LT(free_s, kStep_s);
        const Current free = closed_form(e_W_V, dR_Ohm, now.current_A, free_s);
        const Current railed =
            closed_form(testing::phantom_motor().supply_V, R_Ohm, free.end_A, kStep_s - free_s);
        const double mean_A = (free_s * free.mean_A + (kStep_s - free_s) * railed.mean_A) / kStep_s;
        expect_current(spring_drive_step(testing::phantom_motor(), now, e_W_V, R_hat_Ohm, kStep_s),
                       0.0, {railed.end_A, mean_A});
    }
}

TEST(SpringDrive, DoesNotIncreaseACurrentAtItsLimit) {
    const MotorParameters m = testing::phantom_motor();
    const double supply_V = m.supply_V;
    const double sustaining_V = m.peak_current_A * m.resistance_Ohm; // 11.99 V, just below supply
    ASSERT_LT(sustaining_V, supply_V);
    for (const double sign : {1.0, -1.0}) {
        const auto step = [&](double current_A, double e_W_V) {
            return spring_drive_step(m, {m.resistance_Ohm, sign * current_A, 0.0, true},
                                     sign * e_W_V, 0.0, kStep_s);
        };
        const double below_A = m.peak_current_A * (1.0 - 1e-9);
        const double above_A = m.peak_current_A * 1.2;
        expect_current(step(below_A, supply_V), 0.0,
                       closed_form(sign * supply_V, m.resistance_Ohm, sign * below_A));
        expect_current(step(m.peak_current_A, supply_V), 0.0,
                       {sign * m.peak_current_A, sign * m.peak_current_A}); // stays
        expect_current(step(above_A, supply_V), 0.0,
                       closed_form(sign * sustaining_V, m.resistance_Ohm, sign * above_A));
        // A voltage that reduces the current is passed on.
        expect_current(step(above_A, -6.0), 0.0,
                       closed_form(-sign * 6.0, m.resistance_Ohm, sign * above_A));
    }
}

TEST(SpringDrive, HasNoLimitsWhenTheyAreOff) {
    const DriveState now{testing::phantom_motor().resistance_Ohm, 20.0, 0.0, false};
    expect_current(spring_drive_step(testing::phantom_motor(), now, 50.0, 0.0, kStep_s), 0.0,
                   closed_form(50.0, testing::phantom_motor().resistance_Ohm, 20.0));
}

TEST(CurrentDrive, FollowsAtItsBandwidth) {
    // di/dt = ω_b (i_commanded − i): after a millisecond of sub-steps as after one.
    constexpr double kBandwidth = 2.0 * std::numbers::pi * 200.0;
    double current_A = 0.3;
    double charge_C = 0.0;
    for (int k = 0; k < 40; ++k) {
        const CurrentStep step =
            current_drive_step(testing::phantom_motor(),
                               {testing::phantom_motor().resistance_Ohm, current_A, 20.0, true},
                               1.0, kBandwidth, kStep_s);
        charge_C += kStep_s * step.mean_at(20.0);
        current_A = step.end_at(20.0);
    }
    const double decay = std::exp(-kBandwidth * 1e-3);
    EXPECT_NEAR(current_A, 1.0 - 0.7 * decay, kRoundOff_A);
    EXPECT_NEAR(charge_C, 1e-3 - 0.7 * (1.0 - decay) / kBandwidth, kRoundOff_A * 1e-3);
    EXPECT_EQ(current_drive_step(testing::phantom_motor(), {2.18, 0.0, 0.0, true}, 1.0, kBandwidth,
                                 kStep_s)
                  .mean_As_per_rad,
              0.0); // independent of the rotor's velocity
}

TEST(CurrentDrive, IsLimitedToTheSupplyVoltage) {
    // At a constant 2 A the supply is exhausted at k_T θ̇ = 12 V − R · 2 A, a rotor at 327 rad/s.
    const MotorParameters m = testing::phantom_motor();
    const double spent_rad_per_s =
        (m.supply_V - 2.0 * m.resistance_Ohm) / m.torque_constant_Nm_per_A;
    const auto at = [&](double rate) {
        return current_drive_step(m, {m.resistance_Ohm, 2.0, rate, true}, 2.0, 1e4, kStep_s);
    };
    expect_current(at(0.999 * spent_rad_per_s), 0.0, {2.0, 2.0});
    const double too_fast = 1.1 * spent_rad_per_s;
    expect_current(
        at(too_fast), too_fast,
        closed_form(m.supply_V - m.torque_constant_Nm_per_A * too_fast, m.resistance_Ohm, 2.0));
    // A step that requires more than the winding's slope at 12 V, the fastest possible rise.
    const CurrentStep steep =
        current_drive_step(m, {m.resistance_Ohm, 0.0, 0.0, true}, 5.0, 1e5, kStep_s);
    expect_current(steep, 0.0, closed_form(m.supply_V, m.resistance_Ohm, 0.0));
}

TEST(CurrentDrive, HoldsItsCurrentLimitUnlessLimitsAreOff) {
    const double peak_A = testing::phantom_motor().peak_current_A;
    for (const double commanded_A : {0.9 * peak_A, 1.1 * peak_A, -1.1 * peak_A}) {
        const double held_A = std::clamp(commanded_A, -peak_A, peak_A);
        const DriveState now{2.0, held_A, 0.0, true};
        expect_current(current_drive_step(testing::phantom_motor(), now, commanded_A, 1e4, kStep_s),
                       0.0, {held_A, held_A});
    }
    const DriveState free{2.0, 20.0, 0.0, false};
    expect_current(current_drive_step(testing::phantom_motor(), free, 20.0, 1e4, kStep_s), 0.0,
                   {20.0, 20.0});
}

TEST(SpringDriveAtOnce, IsOhmsLawOnTheResidualResistance) {
    // (11) with L = 0: i = (e_W − k_T θ̇)/dR.
    const double R_Ohm = testing::phantom_motor().resistance_Ohm;
    for (const double dR_Ohm : {R_Ohm, 0.5, 0.02}) {
        for (const double rate : {0.0, 30.0, -30.0}) {
            const double current_A =
                (0.02 - testing::phantom_motor().torque_constant_Nm_per_A * rate) / dR_Ohm;
            const CurrentStep step = spring_drive_at_once(
                testing::phantom_motor(), {R_Ohm, 7.0, rate, false}, 0.02, R_Ohm - dR_Ohm);
            expect_current(step, rate, {current_A, current_A}); // independent of its previous value
        }
    }
}

TEST(SpringDriveAtOnce, IsTheLimitOfSmallInductance) {
    MotorParameters m = testing::phantom_motor();
    m.inductance_H *= 1e-9;
    const DriveState now{m.resistance_Ohm, 0.3, 5.0, false};
    const CurrentStep slow = spring_drive_step(m, now, 0.4, 1.6, kStep_s);
    const CurrentStep at_once = spring_drive_at_once(m, now, 0.4, 1.6);
    // The mean differs by 0.3 A times L/dR over the step, 4e-13 s of 25 µs.
    EXPECT_NEAR(slow.end_at(5.0), at_once.end_at(5.0), kRoundOff_A);
    EXPECT_NEAR(slow.mean_at(5.0), at_once.mean_at(5.0), 1e-7);
}

TEST(SpringDriveAtOnce, KeepsAResidualForAnOverCancelledWinding) {
    const double R_Ohm = testing::phantom_motor().resistance_Ohm;
    const double min_Ohm = kMinResidualShare * R_Ohm;
    for (const double cancelled_Ohm : {R_Ohm - min_Ohm, R_Ohm, R_Ohm + 0.1}) {
        const CurrentStep step = spring_drive_at_once(
            testing::phantom_motor(), {R_Ohm, 0.0, 0.0, false}, 1e-3, cancelled_Ohm);
        expect_current(step, 0.0, {1e-3 / min_Ohm, 1e-3 / min_Ohm});
    }
}

TEST(SpringDriveAtOnce, IsLimitedToTheSupplyVoltage) {
    // At standstill e_A = R̂ i + e_W = e_W R/dR. Nothing limits the current here.
    MotorParameters m = testing::phantom_motor();
    m.peak_current_A = 100.0;
    const double R_Ohm = m.resistance_Ohm;
    const double dR_Ohm = 0.5;
    const double max_V = m.supply_V * dR_Ohm / R_Ohm;
    const auto current_A = [&](double e_W_V) {
        return spring_drive_at_once(m, {R_Ohm, 0.0, 0.0, true}, e_W_V, R_Ohm - dR_Ohm).end_at(0.0);
    };
    EXPECT_NEAR(current_A(0.999 * max_V), 0.999 * m.supply_V / R_Ohm, kRoundOff_A);
    EXPECT_NEAR(current_A(1.001 * max_V), m.supply_V / R_Ohm, kRoundOff_A);
    EXPECT_NEAR(current_A(-3.0 * max_V), -m.supply_V / R_Ohm, kRoundOff_A);
}

TEST(SpringDriveAtOnce, HoldsItsCurrentLimit) {
    MotorParameters m = testing::phantom_motor();
    m.peak_current_A = 2.0;
    const double R_Ohm = m.resistance_Ohm;
    const auto current_A = [&](double requested_A) {
        return spring_drive_at_once(m, {R_Ohm, 0.0, 0.0, true}, 0.5 * requested_A, R_Ohm - 0.5)
            .end_at(0.0);
    };
    EXPECT_NEAR(current_A(1.999), 1.999, kRoundOff_A);
    EXPECT_NEAR(current_A(2.001), 2.0, kRoundOff_A);
    EXPECT_NEAR(current_A(-4.0), -2.0, kRoundOff_A);
}

TEST(CurrentDriveAtOnce, HoldsTheCommandWithinSupplyAndLimit) {
    const MotorParameters m = testing::phantom_motor();
    const double k_T = m.torque_constant_Nm_per_A;
    const double spent_rad_per_s = (m.supply_V - 2.0 * m.resistance_Ohm) / k_T;
    const auto at = [&](double commanded_A, double rate, bool limited) {
        return current_drive_at_once(m, {m.resistance_Ohm, 0.0, rate, limited}, commanded_A)
            .end_at(rate);
    };
    EXPECT_EQ(at(2.0, 0.999 * spent_rad_per_s, true), 2.0);
    const double too_fast = 1.1 * spent_rad_per_s;
    EXPECT_NEAR(at(2.0, too_fast, true), (m.supply_V - k_T * too_fast) / m.resistance_Ohm,
                kRoundOff_A);
    EXPECT_EQ(at(2.0, too_fast, false), 2.0);
    EXPECT_EQ(at(-1.1 * m.peak_current_A, 0.0, true), -m.peak_current_A);
    EXPECT_EQ(at(-1.1 * m.peak_current_A, 0.0, false), -1.1 * m.peak_current_A);
}

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

/// A simulated motor's two harmonics share the file's ripple, so the file's bounds hold.
TEST(WindingResistance, OfTwoHarmonicsIsWithinTheBoundsOfTheirSum) {
    const MotorParameters file = testing::phantom_motor();
    MotorParameters own = file;
    const double second = 0.25;
    own.commutation_ripple /= 1.0 + second;
    own.second_harmonic = second * own.commutation_ripple;
    double largest = 0.0;
    for (int phase = 0; phase < 8; ++phase) {
        own.second_harmonic_phase_rad = 0.25 * std::numbers::pi * phase;
        for (int i = 0; i < 2200; ++i) {
            const double theta_rad = 2.0 * std::numbers::pi * i / 2200;
            const double ripple =
                winding_resistance_Ohm(own, 15.0, theta_rad) / (0.961 * file.resistance_Ohm) - 1.0;
            largest = std::max(largest, std::abs(ripple));
            const double turned_rad = own.commutator_segments * theta_rad;
            EXPECT_NEAR(ripple,
                        0.016 * std::cos(turned_rad) +
                            0.004 * std::cos(2.0 * turned_rad + own.second_harmonic_phase_rad),
                        1e-14);
        }
    }
    EXPECT_NEAR(largest, file.commutation_ripple, 1e-12); // reached at phase 0
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
