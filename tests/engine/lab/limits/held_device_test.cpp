// Covers a device that is held: engine/lab/limits/locked_device.cpp and thermal_hold.cpp.
#include "base/degrees.h"
#include "base/input_error.h"
#include "device/core/motor/winding_heat.h"
#include "device/core/phantom/kinematics.h"
#include "engine/lab/limits/locked_device.h"
#include "engine/lab/limits/thermal_hold.h"
#include "engine/lab/loops/link_plane.h"
#include "tests/support/csv.h"
#include "tests/support/devices.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <sstream>
#include <string>
#include <vector>

namespace springdrive::limits {
namespace {

/// q₂ = 40°; the joint limits leave q₃ − q₂ more room on the negative side.
Vector3 folded(double q3_minus_q2_deg) {
    return kRadiansPerDegree * Vector3(0.0, 40.0, 40.0 + q3_minus_q2_deg);
}

LockedDeviceOptions without_effects(const Vector3 &q_rad) {
    LockedDeviceOptions options;
    options.q_rad = q_rad;
    options.effects = false;
    options.penetration_m = 1e-4; // the inverse map bends by up to Δx/l, here 0.04°
    return options;
}

/// The normal with the largest error of the inverse map, counter-clockwise. With the stiffnesses k₁
/// < k₂ along the ellipse's axes it lies at atan(√(k₁/k₂)) from the first.
double worst_normal_rad(const device::DeviceDescription &device, const Vector3 &q_rad) {
    const Eigen::SelfAdjointEigenSolver<loops::Matrix2> K(
        loops::planar_stiffness(device, control::Tuning{}, q_rad).inverse);
    const loops::Vector2 soft = K.eigenvectors().col(0);
    const double ratio = K.eigenvalues()[0] / K.eigenvalues()[1];
    return std::atan2(soft.y(), soft.x()) + std::atan(std::sqrt(ratio));
}

TEST(LockedDevice, ErrorOfTheInverseMapIsTheAngleBetweenTheLinks) {
    // Fig. 6's amplitude for five configurations: 0.1° is required.
    const device::DeviceDescription device = testing::phantom_1_0();
    for (const double fold_deg : {0.0, -15.0, -30.0, -45.0, -60.0}) {
        const LockedDeviceOptions options = without_effects(folded(fold_deg));
        const LockedForce force = press_locked_device(device, options, control::MotionMap::inverse,
                                                      worst_normal_rad(device, options.q_rad));
        EXPECT_NEAR(std::abs(force.error_rad) / kRadiansPerDegree, std::abs(fold_deg), 0.1);
        EXPECT_NEAR(force.error_rad / kRadiansPerDegree,
                    force.predicted_error_rad / kRadiansPerDegree, 0.1);
    }
}

TEST(LockedDevice, TransposePointsAlongTheNormal) {
    const device::DeviceDescription device = testing::phantom_1_0();
    for (const double fold_deg : {0.0, -30.0, -60.0}) {
        for (const double normal_deg : {-90.0, 10.0, 130.0}) {
            const LockedForce force =
                press_locked_device(device, without_effects(folded(fold_deg)),
                                    control::MotionMap::transpose, kRadiansPerDegree * normal_deg);
            EXPECT_LT(std::abs(force.error_rad) / kRadiansPerDegree, 0.01)
                << fold_deg << ' ' << normal_deg;
            EXPECT_NEAR(force.predicted_error_rad, 0.0, 1e-15);
        }
    }
}

TEST(LockedDevice, ForcesAreThoseOfTheStiffnessEllipse) {
    // Δx/l for the map, the proxy's clearance of 10 nm and the vice's own 1 µm/N.
    const double tolerance = 0.01;
    const device::DeviceDescription device = testing::phantom_1_0();
    LockedDeviceOptions options = without_effects(kRadiansPerDegree * Vector3(25.0, 20.0, -15.0));
    options.tuning.eta = 0.3;
    for (const control::MotionMap map :
         {control::MotionMap::inverse, control::MotionMap::transpose}) {
        for (const double normal_deg : {-90.0, 0.0, 45.0}) {
            const LockedForce force =
                press_locked_device(device, options, map, kRadiansPerDegree * normal_deg);
            EXPECT_LT((force.measured_N - force.predicted_N).norm(),
                      tolerance * force.predicted_N.norm())
                << normal_deg;
        }
    }
}

TEST(LockedDevice, ErrorOfTheTransposeMapIsSmallOnAnImperfectDevice) {
    // 5° is allowed; above a tenth of a degree somewhere, or the effects are missing.
    const device::DeviceDescription device = testing::phantom_1_0();
    for (const double fold_deg : {0.0, -15.0, -30.0, -45.0, -60.0}) {
        LockedDeviceOptions options;
        options.q_rad = folded(fold_deg);
        options.penetration_m = harmless_penetration_m(device, options.tuning, options.q_rad,
                                                       control::MotionMap::transpose);
        double largest_deg = 0.0;
        for (int normal_deg = 0; normal_deg < 360; normal_deg += 15) {
            const LockedForce force = press_locked_device(
                device, options, control::MotionMap::transpose, kRadiansPerDegree * normal_deg);
            largest_deg = std::max(largest_deg, std::abs(force.error_rad) / kRadiansPerDegree);
        }
        EXPECT_LT(largest_deg, 5.0) << fold_deg;
        EXPECT_GT(largest_deg, 0.1) << fold_deg;
    }
}

TEST(LockedDevice, ATripIsReported) {
    const device::DeviceDescription device = testing::phantom_1_0();
    LockedDeviceOptions options;
    options.q_rad = folded(-35.0);
    options.penetration_m = 4.0 * harmless_penetration_m(device, options.tuning, options.q_rad,
                                                         control::MotionMap::inverse);
    const std::string said = error_text_of([&] {
        static_cast<void>(press_locked_device(device, options, control::MotionMap::inverse,
                                              worst_normal_rad(device, options.q_rad)));
    });
    EXPECT_NE(said.find("limit"), std::string::npos) << said;
}

TEST(LockedDevice, RefusesAnglesThatTheJointsCannotTurnTo) {
    const device::DeviceDescription device = testing::phantom_1_0();
    const auto press = [&device](double q3_minus_q2_deg) {
        static_cast<void>(press_locked_device(device, without_effects(folded(q3_minus_q2_deg)),
                                              control::MotionMap::transpose, 0.0));
    };
    EXPECT_THROW(press(-66.0), InputError);
    EXPECT_NO_THROW(press(-64.0));
    EXPECT_THROW(press(NAN), InputError);
}

TEST(LockedDevice, HarmlessPenetrationKeepsWithinTheLimits) {
    // Against brute force: no normal requests more than half of either limit, and one requests all
    // of that half, unless the penetration is the largest there is.
    const device::DeviceDescription device = testing::phantom_premium_1_5();
    for (const double K_P : {0.5, 6.0, 20.0}) {
        control::Tuning tuning;
        tuning.K_P_V_per_rad = K_P;
        const Vector3 q = folded(-40.0);
        const double penetration_m =
            harmless_penetration_m(device, tuning, q, control::MotionMap::inverse);
        const loops::PlanarStiffness stiffness = loops::planar_stiffness(device, tuning, q);
        const loops::Matrix2 J = loops::planar_jacobian(device.geometry, q);
        double share = 0.0;
        for (int i = 0; i < 3600; ++i) {
            const loops::Vector2 force = penetration_m * stiffness.inverse *
                                         loops::direction_at(0.1 * kRadiansPerDegree * i);
            const loops::Vector2 current_A =
                J.transpose() * force / device.motor[1].torque_constant_Nm_per_A;
            share = std::max({share, force.norm() / device.limits.tip_force_N,
                              current_A.cwiseAbs().maxCoeff() / device.motor[1].peak_current_A});
        }
        EXPECT_LE(share, 0.5 + 1e-12);
        if (penetration_m < 4e-3) {
            EXPECT_GT(share, 0.5 * (1.0 - 1e-5)); // a normal 0.05° off the worst
        }
    }
}

constexpr double kLong_s = 10000.0; ///< sixteen time constants of the motor

device::DeviceDescription device() { return testing::phantom_1_0(); }

ThermalHoldOptions hold(double force_N, double seconds) {
    ThermalHoldOptions options;
    options.force_N = force_N;
    options.seconds = seconds;
    return options;
}

ThermalRow last_of(const std::vector<ThermalRow> &rows, ThermalPhase phase) {
    const auto found = std::find_if(rows.rbegin(), rows.rend(),
                                    [phase](const ThermalRow &row) { return row.phase == phase; });
    EXPECT_NE(found, rows.rend());
    return *found;
}

Vector3 theta_rad(const device::DeviceDescription &d, const ThermalHoldOptions &options) {
    return device::motor_from_joint(d.geometry, options.q_rad);
}

Matrix3 jacobian(const device::DeviceDescription &d, const ThermalHoldOptions &options) {
    return device::motor_jacobian(d.geometry, options.q_rad);
}

/// Static currents of a force along the normal: τ = Jᵀ F (22).
Vector3 currents_A(const device::DeviceDescription &d, const ThermalHoldOptions &options) {
    return jacobian(d, options).transpose() * options.direction.normalized() * options.force_N /
           d.motor[0].torque_constant_Nm_per_A;
}

/// Final temperature of a winding with fixed R̂: T = T_a + i² R(T, θ) (R_wh + R_ha) with i =
/// e_W/(R(T, θ) − R̂), found by bisection.
double final_winding_C(const device::MotorParameters &motor, double theta, double e_W_V,
                       double R_hat_Ohm, double air_C) {
    const double K_per_W =
        motor.thermal.winding_housing_K_per_W + motor.thermal.housing_ambient_K_per_W;
    double low_C = air_C;
    double high_C = 500.0;
    for (int i = 0; i < 100; ++i) {
        const double middle_C = 0.5 * (low_C + high_C);
        const double R_Ohm = device::winding_resistance_Ohm(motor, middle_C, theta);
        const double current_A = e_W_V / (R_Ohm - R_hat_Ohm);
        (air_C + current_A * current_A * R_Ohm * K_per_W > middle_C ? low_C : high_C) = middle_C;
    }
    return low_C;
}

TEST(ThermalHold, StartsAsRequestedAndAsTuned) {
    for (const Vector3 &direction : {Vector3(0, 1, 0), Vector3(0, -3, 0), Vector3(1, 2, -1)}) {
        ThermalHoldOptions options = hold(1.2, 10.0);
        options.direction = direction;
        const ThermalRow first = thermal_hold(device(), options).front();
        EXPECT_EQ(first.time_s, 0.0);
        EXPECT_NEAR(first.tip_force_N, 1.2, 1e-12);
        EXPECT_LT(first.direction_error_rad, 1e-12);
        EXPECT_EQ(first.dR_Ohm, first.dR_unlimited_Ohm); // so loose that nothing limits R̂
        EXPECT_TRUE(std::isnan(first.growth_time_s));
        for (int j = 0; j < 3; ++j) {
            EXPECT_NEAR(first.dR_Ohm[j], options.tuning.dR_Ohm, 1e-13);
            EXPECT_EQ(first.winding_C[j], 25.0);
        }
    }
}

TEST(ThermalHold, EndsAtTheHeatBalance) {
    const device::DeviceDescription d = device();
    const ThermalHoldOptions options = hold(1.2, kLong_s);
    const ThermalRow last = last_of(thermal_hold(d, options), ThermalPhase::hold);
    const Vector3 theta = theta_rad(d, options);
    const Vector3 e_W_V = options.tuning.dR_Ohm * currents_A(d, options);
    for (std::size_t j = 0; j < 3; ++j) {
        const auto axis = static_cast<Eigen::Index>(j);
        const double R_hat_Ohm =
            device::winding_resistance_Ohm(d.motor[j], 25.0, theta[axis]) - options.tuning.dR_Ohm;
        // Sixteen time constants leave 1e-7 of the warmth.
        EXPECT_NEAR(last.winding_C[axis],
                    final_winding_C(d.motor[j], theta[axis], e_W_V[axis], R_hat_Ohm, 25.0), 1e-5);
    }
    EXPECT_GT(last.winding_C.maxCoeff(), 35.0); // not vacuous
}

TEST(ThermalHold, WarmsAsAnIndependentIntegration) {
    // One motor, tiny explicit steps of the two heat balances. The hold's power is constant for 10
    // ms: a lag of half of that while warming, initially at some 1 K/s.
    const device::DeviceDescription d = device();
    const ThermalHoldOptions options = hold(2.0, 20.0);
    const ThermalRow last = last_of(thermal_hold(d, options), ThermalPhase::hold);
    const device::MotorParameters &m = d.motor[1];
    const device::ThermalParameters &t = m.thermal;
    const double theta = theta_rad(d, options)[1];
    const double e_W_V = options.tuning.dR_Ohm * currents_A(d, options)[1];
    const double R_hat_Ohm = device::winding_resistance_Ohm(m, 25.0, theta) - options.tuning.dR_Ohm;
    double winding_C = 25.0;
    double housing_C = 25.0;
    constexpr int kSteps = 200000;
    const double h = 20.0 / kSteps;
    for (int i = 0; i < kSteps; ++i) {
        const double R_Ohm = device::winding_resistance_Ohm(m, winding_C, theta);
        const double current_A = e_W_V / (R_Ohm - R_hat_Ohm);
        const double inner_W = (winding_C - housing_C) / t.winding_housing_K_per_W;
        const double outer_W = (housing_C - 25.0) / t.housing_ambient_K_per_W;
        winding_C += h * (current_A * current_A * R_Ohm - inner_W) /
                     (t.winding_time_s / t.winding_housing_K_per_W);
        housing_C += h * (inner_W - outer_W) / (t.motor_time_s / t.housing_ambient_K_per_W);
    }
    EXPECT_GT(winding_C, 27.0);
    EXPECT_NEAR(last.winding_C[1], winding_C, 5e-3);
}

TEST(ThermalHold, ResistanceAndStiffnessFollowTheTemperature) {
    const device::DeviceDescription d = device();
    const ThermalHoldOptions options = hold(1.4, 600.0);
    const std::vector<ThermalRow> rows = thermal_hold(d, options);
    const Vector3 theta = theta_rad(d, options);
    for (const ThermalRow &row : rows) {
        if (row.phase == ThermalPhase::cool) {
            break;
        }
        for (std::size_t j = 0; j < 3; ++j) {
            const auto axis = static_cast<Eigen::Index>(j);
            const double R25_Ohm = device::winding_resistance_Ohm(d.motor[j], 25.0, theta[axis]);
            const double risen_Ohm = R25_Ohm * 0.0039 * (row.winding_C[axis] - 25.0);
            EXPECT_NEAR(row.dR_Ohm[axis], options.tuning.dR_Ohm + risen_Ohm, 1e-12);
            EXPECT_NEAR(row.K_DC_Nm_per_rad[axis],
                        d.motor[j].torque_constant_Nm_per_A * options.tuning.K_P_V_per_rad /
                            row.dR_Ohm[axis],
                        1e-12);
        }
    }
    const ThermalRow hot = last_of(rows, ThermalPhase::hold);
    EXPECT_LT(hot.tip_force_N, 0.95 * options.force_N);
    EXPECT_GT(hot.direction_error_rad, 0.01);
}

/// Motors that warm equally, or whose resistance does not rise, keep the direction; the latter keep
/// the force too.
TEST(ThermalHold, OnlyUnequalResistancesTurnTheForce) {
    for (const bool rises : {true, false}) {
        device::DeviceDescription d = device();
        ThermalHoldOptions options = hold(2.5, 600.0);
        for (device::MotorParameters &motor : d.motor) {
            motor.commutation_ripple = rises ? 0.0 : motor.commutation_ripple;
            motor.resistance_rise_per_K *= rises ? 1.0 : 0.0;
        }
        if (rises) { // Jᵀ n is the same on every motor
            options.direction = jacobian(d, options).transpose().inverse() * Vector3::Ones();
        }
        const ThermalRow hot = last_of(thermal_hold(d, options), ThermalPhase::hold);
        EXPECT_GT(hot.winding_C.maxCoeff(), 27.0);
        EXPECT_LT(hot.direction_error_rad, 1e-12);
        EXPECT_NEAR(hot.tip_force_N / options.force_N, 1.0, rises ? 1.0 : 1e-12);
        EXPECT_EQ(hot.tip_force_N < 0.99 * options.force_N, rises);
    }
}

TEST(ThermalHold, TunedHotAndCooledOnlyTheLimitKeepsANetResistance) {
    const device::DeviceDescription d = device();
    ThermalHoldOptions options = hold(4.0, 1200.0);
    options.tuning.dR_Ohm = 0.1;
    for (const double sign : {1.0, -1.0}) {
        options.direction = sign * Vector3::UnitY();
        const std::vector<ThermalRow> rows = thermal_hold(d, options);
        const ThermalRow cold = last_of(rows, ThermalPhase::cool);
        EXPECT_LT(cold.dR_unlimited_Ohm[1], -0.02);
        EXPECT_NEAR(cold.growth_time_s,
                    d.motor[0].inductance_H / -cold.min_dR_unlimited_Ohm.minCoeff(), 1e-15);
        const Vector3 theta = theta_rad(d, options);
        for (const ThermalRow &row : rows) {
            EXPECT_EQ(std::isnan(row.growth_time_s), row.min_dR_unlimited_Ohm.minCoeff() >= 0.0);
            for (std::size_t j = 0; j < 3; ++j) {
                const auto axis = static_cast<Eigen::Index>(j);
                const double R_Ohm =
                    device::winding_resistance_Ohm(d.motor[j], row.winding_C[axis], theta[axis]);
                const double min_Ohm = device::min_resistance_Ohm(d.motor[j], row.winding_C[axis]);
                EXPECT_NEAR(row.dR_Ohm[axis], R_Ohm - row.R_hat_allowed_Ohm[axis], 1e-13);
                EXPECT_GT(row.min_dR_Ohm[axis], device::kMinResidualShare * min_Ohm);
                EXPECT_NEAR(row.min_dR_Ohm[axis], min_Ohm - row.R_hat_allowed_Ohm[axis], 1e-13);
            }
        }
    }
}

TEST(ThermalHold, TheRetunedResistanceIsTheOneTunedCold) {
    const ThermalHoldOptions options = hold(2.0, 300.0);
    const std::vector<ThermalRow> rows = thermal_hold(device(), options);
    const ThermalRow hot = last_of(rows, ThermalPhase::hold);
    const ThermalRow &retuned = rows[static_cast<std::size_t>(options.rows)];
    EXPECT_EQ(retuned.phase, ThermalPhase::cool);
    EXPECT_EQ(retuned.time_s, hot.time_s);
    EXPECT_GT(hot.dR_Ohm[1], 1.1 * options.tuning.dR_Ohm);
    EXPECT_NEAR(retuned.dR_Ohm[1], options.tuning.dR_Ohm, 1e-13);
    EXPECT_EQ(retuned.tip_force_N, 0.0);
    EXPECT_TRUE(std::isnan(retuned.direction_error_rad));
}

TEST(ThermalHold, EndsWhereTheSafetyMonitorTrips) {
    ThermalHoldOptions options = hold(1.4, kLong_s);
    EXPECT_FALSE(thermal_hold(device(), options).back().tripped);
    options.force_N = 8.0;
    const std::vector<ThermalRow> rows = thermal_hold(device(), options);
    EXPECT_TRUE(rows.back().tripped);
    EXPECT_EQ(rows.back().phase, ThermalPhase::hold);
    EXPECT_LT(rows.back().time_s, kLong_s);
    EXPECT_TRUE(std::none_of(rows.begin(), rows.end() - 1,
                             [](const ThermalRow &row) { return row.tripped; }));
    // The upper estimate errs on the safe side: by the air temperature, and by its effect on R.
    EXPECT_LT(rows.back().winding_C.maxCoeff(), 100.0);
    EXPECT_GT(rows.back().winding_C.maxCoeff(), 75.0);
}

TEST(ThermalHold, RefusesInvalidOptions) {
    using Change = std::function<void(ThermalHoldOptions &)>;
    const double nan = std::nan("");
    std::vector<Change> changes{[](ThermalHoldOptions &o) { o.tuning.K_P_V_per_rad = 0.0; }};
    for (const double bad : {0.0, -1.0, nan, 86401.0}) { // seconds, and newtons
        changes.emplace_back([=](ThermalHoldOptions &o) { o.seconds = bad; });
        changes.emplace_back([=](ThermalHoldOptions &o) { o.force_N = bad; });
    }
    changes.emplace_back([](ThermalHoldOptions &o) { o.force_N = 8.6; });
    for (const int rows : {-1, 0, 1, 100001}) {
        changes.emplace_back([=](ThermalHoldOptions &o) { o.rows = rows; });
    }
    for (const double air_C : {nan, device::kColdestAir_C - 0.1, device::kWarmestAir_C + 0.1}) {
        changes.emplace_back([=](ThermalHoldOptions &o) { o.ambient_C = air_C; });
    }
    for (const Vector3 &q_rad : {Vector3(0, nan, 0), Vector3(2.0, 0, 0), Vector3(0, -0.6, 0.6)}) {
        changes.emplace_back([=](ThermalHoldOptions &o) { o.q_rad = q_rad; });
    }
    for (const double length : {0.0, nan}) {
        changes.emplace_back([=](ThermalHoldOptions &o) { o.direction = Vector3(0, length, 0); });
    }
    EXPECT_NO_THROW(static_cast<void>(thermal_hold(device(), hold(1.0, 1.0))));
    for (std::size_t i = 0; i < changes.size(); ++i) {
        ThermalHoldOptions options = hold(1.0, 1.0);
        changes[i](options);
        EXPECT_THROW(static_cast<void>(thermal_hold(device(), options)), InputError) << i;
    }
}

TEST(ThermalHold, RefusesAForceBeyondTheMotors) {
    // Both sides of the force at which the first motor meets its peak current or its supply.
    device::DeviceDescription d = device();
    ThermalHoldOptions options = hold(1.0, 0.1);
    d.motor[1].peak_current_A = 1.0;
    d.motor[2].supply_V = 1.0;
    const Vector3 ampere_per_N = currents_A(d, options).cwiseAbs();
    const double R3_Ohm =
        device::winding_resistance_Ohm(d.motor[2], 25.0, theta_rad(d, options)[2]);
    const double max_N = std::min(1.0 / ampere_per_N[1], 1.0 / (R3_Ohm * ampere_per_N[2]));
    options.force_N = 0.999 * max_N;
    EXPECT_NO_THROW(static_cast<void>(thermal_hold(d, options)));
    options.force_N = 1.001 * max_N;
    EXPECT_THROW(static_cast<void>(thermal_hold(d, options)), InputError);
}

TEST(ThermalHold, WritesEveryRowAndASummary) {
    const auto written = [](double force_N, double dR_Ohm) {
        ThermalHoldOptions options = hold(force_N, 1200.0);
        options.tuning.dR_Ohm = dR_Ohm;
        const std::vector<ThermalRow> rows = thermal_hold(device(), options);
        std::ostringstream csv;
        write_csv(csv, thermal_table(rows));
        const auto lines = testing::parsed_csv(csv.str());
        EXPECT_EQ(lines.size(), 1 + rows.size());
        EXPECT_EQ(lines[0].size(), 30U);
        EXPECT_EQ(lines[0][2], "winding1_C");
        for (const auto &line : lines) {
            EXPECT_EQ(line.size(), lines[0].size());
            EXPECT_EQ(std::ranges::count(line, "nan"), 0);
        }
        std::ostringstream text;
        write_thermal_table(text, rows);
        EXPECT_EQ(text.str().find("nan"), std::string::npos);
        return text.str();
    };
    EXPECT_NE(written(4.0, 0.1).find("over-cancelled from"), std::string::npos);
    EXPECT_EQ(written(1.0, 1.2).find("over-cancelled"), std::string::npos); // tuned loosely
    EXPECT_NE(written(8.0, 0.5).find("safety monitor trips"), std::string::npos);
}

} // namespace
} // namespace springdrive::limits
