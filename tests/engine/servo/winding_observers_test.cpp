// Covers engine/servo/winding_observers.cpp and what servo and safety monitor make of it, against
// the true state of drawn devices: a hand waits in free space, then touches a slanted plane.
#include "engine/servo/winding_observers.h"

#include "device/core/phantom/kinematics.h"
#include "device/simulated/plant_setup.h"
#include "engine/contact/mesh/triangle_soup.h"
#include "engine/control/haptic_law.h"
#include "engine/control/rendered_force.h"
#include "engine/lab/limits/locked_device.h"
#include "engine/lab/rig/servo_rig.h"
#include "tests/support/calibrations.h"
#include "tests/support/cases.h"
#include "tests/support/devices.h"
#include "tests/support/fault_judge.h"
#include "tests/support/tunings.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <vector>

namespace springdrive::servo {
namespace {

constexpr double kBeforeTouch_s = 1.5; ///< in which the servo starts
constexpr double kPressed_s = 0.5;     ///< until the hand has pressed to its depth
constexpr double kPeriod_s = 1e-3;

struct Touch {
    double dR_Ohm = 0.5;
    double duration_s = 2.5;
    double stroke_m = 0.012;
    double depth_m = 0.004;
    double air_C = 25.0;
    double rest_s = 0.0; ///< in free space, before a second touch as long as the first
    double period_s = kPeriod_s;
    double delay_periods = 0.0;
    bool has_brushes = true; ///< and the file says nothing of V_b but its largest value
};

device::DeviceDescription file_of(const Touch &touch) {
    return touch.has_brushes ? testing::phantom_1_0() : testing::phantom_without_brushes();
}

/// The plane, and where the tip waits above it.
const Vector3 kStart_m{0.0, 0.04, 0.0};
constexpr double kAbove_m = 0.003;

Vector3 normal() { return Vector3(0.5, 0.6, 0.62).normalized(); }

/// A square of 0.4 m.
const contact::HapticSurface &plane() {
    static const contact::HapticSurface surface = [] {
        const Vector3 along = normal().unitOrthogonal();
        const Vector3 across = normal().cross(along);
        const Vector3 middle_m = kStart_m - kAbove_m * normal();
        contact::TriangleSoup soup;
        for (const auto &[a, b] : {std::pair(-0.2, -0.2), {0.2, -0.2}, {0.2, 0.2}, {-0.2, 0.2}}) {
            soup.vertices_m.emplace_back(middle_m + a * along + b * across);
        }
        soup.triangles = {{0, 1, 2}, {0, 2, 3}};
        soup.material_of_triangle = {0, 0};
        soup.materials = {{"plane", 0.0}};
        return contact::HapticSurface(soup);
    }();
    return surface;
}

/// From `begin_s` on: pressed, then moved to and fro in two directions, then lifted again.
void add_touch(const Touch &touch, double begin_s,
               std::vector<simulated::HandPath::Point> &points) {
    constexpr double kStep_s = 0.02;
    const Vector3 along = normal().unitOrthogonal();
    const Vector3 across = normal().cross(along);
    const long steps = std::lround(touch.duration_s / kStep_s);
    for (long i = 1; i <= steps; ++i) {
        const double time_s = static_cast<double>(i) * kStep_s;
        const double pressed = std::min(1.0, time_s / kPressed_s);
        const double phase = std::numbers::pi * time_s;
        const Vector3 aside = std::sin(phase) * along + std::sin(1.3 * phase) * across;
        points.push_back({begin_s + time_s, kStart_m -
                                                pressed * (kAbove_m + touch.depth_m) * normal() +
                                                pressed * 0.5 * touch.stroke_m * aside});
    }
}

simulated::SimulationOptions options(const Touch &touch, int seed) {
    simulated::SimulationOptions options;
    options.device_seed = static_cast<std::uint64_t>(seed);
    options.ambient_C = touch.air_C;
    options.servo_period_s = touch.period_s;
    options.delay_periods = touch.delay_periods;
    std::vector<simulated::HandPath::Point> points{{0.0, kStart_m}, {kBeforeTouch_s, kStart_m}};
    add_touch(touch, kBeforeTouch_s, points);
    if (touch.rest_s > 0.0) {
        const double lifted_s = kBeforeTouch_s + touch.duration_s + kPressed_s;
        points.push_back({lifted_s, kStart_m});
        points.push_back({lifted_s + touch.rest_s, kStart_m});
        add_touch(touch, lifted_s + touch.rest_s, points);
    }
    options.path.emplace(std::move(points));
    return options;
}

/// A drawn device in that touch, with the whole servo.
class TouchedDevice {
public:
    TouchedDevice(const Touch &touch, int seed) : TouchedDevice(touch, options(touch, seed)) {}

    TouchedDevice(const Touch &touch, const simulated::SimulationOptions &simulation)
        : rig(file_of(touch), simulation, kStart_m, &plane()),
          drawn(simulated::sampled_device(file_of(touch), simulation.device_seed)) {
        rig.inputs.tuning.dR_Ohm = touch.dR_Ohm;
        rig.inputs.observes_resistance = true;
    }

    void run_to(double time_s) {
        const double period_s = rig.loop().period_s();
        while (static_cast<double>(ticks_) * period_s < time_s) {
            rig.tick();
            ++ticks_;
        }
    }

    /// 1 + g of the sensor whose current the amplifier multiplies by R̂.
    [[nodiscard]] double gain(std::size_t motor) const {
        return drawn.motor[motor].sensing.amplifier.gain;
    }
    /// R(T, θ)/(1 + g).
    [[nodiscard]] double seen_Ohm(std::size_t motor) const {
        return rig.truth().resistance_Ohm[static_cast<Eigen::Index>(motor)] / gain(motor);
    }
    /// What is left of the winding's resistance.
    [[nodiscard]] double dR_Ohm(std::size_t motor) const {
        return gain(motor) *
               (seen_Ohm(motor) -
                rig.last.command.cancelled_resistance_Ohm[static_cast<Eigen::Index>(motor)]);
    }
    [[nodiscard]] const control::ObservedMotor &known(std::size_t motor) const {
        return rig.last.motor[motor];
    }
    [[nodiscard]] bool is_limited(std::size_t motor) const {
        return rig.last.winding[motor].is_limited;
    }

    rig::ServoRig rig;
    simulated::SampledDevice drawn;

private:
    std::uint64_t ticks_ = 0;
};

/// The largest error of dR/(1 + g) while a device is touched, as a share of what was asked for.
/// Where the safety monitor limits R̂, nothing is compared.
double worst_error(TouchedDevice &device, const Touch &touch, double from_s, double to_s) {
    double worst = 0.0;
    const long ticks = std::lround((to_s - from_s) / touch.period_s);
    for (long tick = 0; tick < ticks; ++tick) {
        device.run_to(from_s + static_cast<double>(tick) * touch.period_s);
        EXPECT_FALSE(device.rig.has_tripped()) << description(device.rig.last.safety);
        for (std::size_t motor = 0; motor < 3; ++motor) {
            if (!device.is_limited(motor)) {
                const double seen_Ohm = device.dR_Ohm(motor) / device.gain(motor);
                worst = std::max(worst, std::abs(seen_Ohm - touch.dR_Ohm) / touch.dR_Ohm);
            }
        }
    }
    return worst;
}

// Where the winding guard allows it: at 0.2 Ω on few motors. Its goals are 1 % at 0.5 Ω and 3 % at
// 0.2 Ω. The sensor's own gain, up to 1 % of dR at any dR,
// comes on top: it scales what the servo reads of R̂, of R and of L alike. A motor that carries some
// 10 or 20 mA, since the force does not need it, may not be known as well; then its deviation says
// so.
TEST(WindingObservers, DRIsWhatWasAskedForAfterTwoSeconds) {
    const int devices = testing::cases(6, 1000);
    for (const double dR_Ohm : {0.5, 0.2}) {
        const double goal = dR_Ohm > 0.3 ? 0.01 : 0.03;
        double worst = 0.0;
        double held_up_Ohm = 0.0;
        int held_up = 0;
        int missed = 0;
        for (int seed = 1; seed <= devices; ++seed) {
            Touch touch;
            touch.dR_Ohm = dR_Ohm;
            touch.air_C = 15.0 + 5.0 * (seed % 5);
            TouchedDevice device(touch, seed);
            const double from_s = kBeforeTouch_s + 2.0;
            device.run_to(from_s);
            double deviation_Ohm = 0.0;
            for (const control::ObservedMotor &R : device.rig.last.motor) {
                deviation_Ohm = std::max(deviation_Ohm, R.here.deviation_Ohm);
            }
            const double error =
                worst_error(device, touch, from_s, kBeforeTouch_s + touch.duration_s);
            worst = std::max(worst, error);
            // A motor of which too little is known is held up.
            const bool is_known = control::kHeldUpDeviations * deviation_Ohm < dR_Ohm;
            missed += error < goal || !is_known ? 0 : 1;
            for (std::size_t motor = 0; motor < 3; ++motor) {
                held_up += device.is_limited(motor) ? 1 : 0;
                held_up_Ohm = std::max(held_up_Ohm, device.dR_Ohm(motor));
            }
            // The largest of some 45,000 windows is expected at 4.2 deviations.
            EXPECT_LT(error, std::max(goal, 5.0 * deviation_Ohm / dR_Ohm))
                << dR_Ohm << " Ω, device " << seed;
        }
        EXPECT_LE(missed, devices / 50);
        std::printf("worst of %d at %g Ω: %.2f %%, %d above %g %%; %d of %d motors held up, to "
                    "%.2f Ω\n",
                    devices, dR_Ohm, 100.0 * worst, missed, 100.0 * goal, held_up, 3 * devices,
                    held_up_Ohm);
    }
}

// Of motors without brushes: with V_b, R is known only as well as |i| varies, and dR held up.
// 300 s at 1.4 N warm the windings; then a minute in which they cool, and the touch again. Goals: 2
// % at 0.5 Ω and 5 % at 0.2 Ω.
TEST(WindingObservers, DRStaysWhatWasAskedForInALongTouchAndAfterRest) {
    const bool is_long = testing::cases(0, 1) == 1;
    const int devices = testing::cases(1, 3);
    for (const double dR_Ohm : {0.5, 0.2}) {
        double worst = 0.0;
        double force_N = 0.0;
        for (int seed = 1; seed <= devices; ++seed) {
            for (const double air_C : {15.0, 35.0}) {
                for (const double stroke_m : {0.012, 0.0}) {
                    Touch touch;
                    touch.dR_Ohm = dR_Ohm;
                    touch.duration_s = is_long ? 300.0 : 10.0;
                    touch.rest_s = is_long ? 60.0 : 5.0;
                    touch.has_brushes = false;
                    touch.air_C = air_C;
                    touch.depth_m = 0.0054;
                    touch.stroke_m = stroke_m;
                    TouchedDevice device(touch, seed);
                    const double first_s = kBeforeTouch_s + 2.0;
                    const double lifted_s = kBeforeTouch_s + touch.duration_s;
                    const double second_s = lifted_s + kPressed_s + touch.rest_s;
                    device.run_to(first_s);
                    double error = worst_error(device, touch, first_s, lifted_s);
                    force_N += device.rig.last.tip_force_N.norm() / (4.0 * devices);
                    if (stroke_m > 0.0) { // elsewhere, a still touch has told little
                        device.run_to(second_s);
                        error = std::max(error, worst_error(device, touch, second_s + 0.2,
                                                            second_s + touch.duration_s));
                    }
                    if (stroke_m == 0.0 && dR_Ohm < 0.3) {
                        continue; // held up by a ripple that the rotor never showed
                    }
                    EXPECT_LT(error, dR_Ohm > 0.3 ? 0.02 : 0.05)
                        << dR_Ohm << " Ω, device " << seed << ", air " << air_C << ", stroke "
                        << stroke_m;
                    worst = std::max(worst, error);
                }
            }
        }
        std::printf("worst of %d at %g Ω and %.2f N: %.2f %%\n", 4 * devices, dR_Ohm, force_N,
                    100.0 * worst);
    }
}

/// Whether a count of hits of 95 % is within three standard deviations of a binomial, and, where
/// that is narrower, within 93 and 97 %.
void expect_95_percent(int within, int count, const char *what) {
    const double share = static_cast<double>(within) / count;
    const double chance = 3.0 * std::sqrt(0.95 * 0.05 / count);
    EXPECT_GE(share, 0.95 - std::max(0.02, chance)) << what;
    EXPECT_LE(share, 0.95 + std::max(0.02, chance)) << what;
    std::printf("worst of %d %s: %.1f %% within the interval of 95 %%\n", count, what,
                100.0 * share);
}

// Of R at the angle where the tip is, one motor of each device, so that each counts by itself.
TEST(WindingObservers, TheIntervalsHoldWhatTheySay) {
    const int devices = testing::cases(60, 1000);
    for (const double stroke_m : {0.012, 0.0}) {
        int within = 0;
        for (int seed = 1; seed <= devices; ++seed) {
            Touch touch;
            touch.stroke_m = stroke_m;
            touch.dR_Ohm = seed % 2 == 0 ? 0.5 : 0.2;
            touch.air_C = 15.0 + 5.0 * (seed % 5);
            TouchedDevice device(touch, seed);
            device.run_to(kBeforeTouch_s + touch.duration_s);
            const auto motor = static_cast<std::size_t>(seed % 3);
            const control::ResistanceEstimate &R = device.known(motor).here;
            within += std::abs(R.resistance_Ohm - device.seen_Ohm(motor)) < 1.96 * R.deviation_Ohm
                          ? 1
                          : 0;
        }
        expect_95_percent(within, devices, stroke_m > 0.0 ? "moved" : "held still");
    }
}

/// The angles between force and normal, as a vice measures them in figure 6 [°].
std::vector<double> direction_errors_deg(const control::Tuning &tuning, bool is_observed,
                                         int devices, int surfaces) {
    const device::DeviceDescription device = testing::phantom_1_0();
    limits::LockedDeviceOptions options;
    options.tuning = tuning;
    options.q_rad = device::default_pose_rad();
    options.observes_resistance = is_observed;
    options.penetration_m = limits::harmless_penetration_m(device, tuning, options.q_rad,
                                                           control::MotionMap::transpose);
    std::vector<double> errors_deg;
    for (int seed = 1; seed <= devices; ++seed) {
        options.device_seed = static_cast<std::uint64_t>(seed);
        for (int i = 0; i < surfaces; ++i) {
            const limits::LockedForce force =
                limits::press_locked_device(device, options, control::MotionMap::transpose,
                                            2.0 * std::numbers::pi * i / surfaces);
            errors_deg.push_back(std::abs(force.error_rad) * 180.0 / std::numbers::pi);
        }
    }
    std::ranges::sort(errors_deg);
    return errors_deg;
}

// The goal is 3°. It is missed by 0.1°: friction alone turns the force by up to 2.3°, the sensors'
// gains, which differ by up to 2 %, by the rest.
TEST(WindingObservers, TheForcePointsAlongTheNormal) {
    const int devices = testing::cases(2, 20);
    const int surfaces = testing::cases(6, 24);
    for (const char *name : {"firm", "stable_only_1kHz"}) {
        const control::Tuning tuning = testing::tuning(name);
        const auto print = [&](const std::vector<double> &errors_deg, const char *how) {
            std::printf("worst of %zu, %s, %s: %.1f°, 95 %% below %.1f°\n", errors_deg.size(), name,
                        how, errors_deg.back(), errors_deg[errors_deg.size() * 95 / 100]);
        };
        const std::vector<double> file = direction_errors_deg(tuning, false, devices, surfaces);
        const std::vector<double> seen = direction_errors_deg(tuning, true, devices, surfaces);
        print(file, "unobserved");
        print(seen, "observed");
        // K_q (20) is off by up to 1 % of gain and 0.5 % of dR in each motor, which turns the force
        // by asin(1.92 · 1.5 %) = 1.7° with J's condition number in this pose, k_T's ripple of 2 %
        // by 2.2°, friction by 2.3°.
        // Below some 0.35 Ω the guard holds dR up where R is above the smallest of its file; K_P
        // follows, so that K_q stays equal.
        EXPECT_LT(seen.back(), 6.2) << name;
        if (devices == 20) {
            EXPECT_LT(seen.back(), 0.3 * file.back()) << name;
        }
    }
}

/// The mean force at the tip of the true currents [N].
double mean_force_N(TouchedDevice &device, double from_s, double to_s) {
    const device::DeviceDescription file = testing::phantom_1_0();
    Vector3 k_T;
    for (std::size_t motor = 0; motor < 3; ++motor) {
        k_T[static_cast<Eigen::Index>(motor)] = file.motor[motor].torque_constant_Nm_per_A *
                                                device.drawn.motor[motor].torque_constant_share;
    }
    Vector3 sum_N = Vector3::Zero();
    const int ticks = static_cast<int>(std::lround((to_s - from_s) / kPeriod_s));
    for (int tick = 1; tick <= ticks; ++tick) {
        device.run_to(from_s + tick * kPeriod_s);
        const testing::TipAt tip(file.geometry, device.rig.truth().theta_rad);
        sum_N += tip.force_N(k_T.cwiseProduct(device.rig.truth().current_A));
    }
    return sum_N.norm() / ticks;
}

// By an offset of 20 mA, R̂ adds up to 60 mV to e_W, of which dR makes a current. The mean of what
// the sensor read tells the offset as well as its noise allows.
TEST(WindingObservers, OffsetsMakeNoForceInFreeSpace) {
    const int devices = testing::cases(3, 200);
    const device::DeviceDescription file = testing::phantom_1_0();
    const double reading_A = std::hypot(file.current_sensing.noise_A,
                                        file.current_sensing.resolution_A / std::sqrt(12.0));
    for (const double dR_Ohm : {0.5, 0.2}) {
        double unobserved_N = 0.0;
        double first_N = 0.0;
        double worst_N = 0.0;
        double worst_A = 0.0;
        for (int seed = 1; seed <= devices; ++seed) {
            Touch touch;
            touch.dR_Ohm = dR_Ohm;
            touch.rest_s = 1.0;
            touch.has_brushes = false;
            const double free_s = kBeforeTouch_s + touch.duration_s + kPressed_s + 0.5;
            TouchedDevice without(touch, seed);
            without.rig.inputs.observes_resistance = false;
            without.run_to(free_s);
            unobserved_N = std::max(unobserved_N, mean_force_N(without, free_s, free_s + 0.5));

            TouchedDevice device(touch, seed);
            device.run_to(kBeforeTouch_s - 0.2);
            first_N = std::max(first_N, mean_force_N(device, kBeforeTouch_s - 0.2, kBeforeTouch_s));
            device.run_to(free_s);
            worst_N = std::max(worst_N, mean_force_N(device, free_s, free_s + 0.5));
            for (std::size_t motor = 0; motor < 3; ++motor) {
                worst_A = std::max(worst_A,
                                   std::abs(device.known(motor).offset_A -
                                            device.drawn.motor[motor].sensing.amplifier.offset_A));
            }
        }
        std::printf("worst of %d at %g Ω: %.4f N, before the first touch %.4f N, unobserved %.4f "
                    "N; offset %.3f mA\n",
                    devices, dR_Ohm, worst_N, first_N, unobserved_N, 1e3 * worst_A);
        const double offset_A = 5.0 * reading_A / std::sqrt(Touch{}.duration_s / kPeriod_s);
        EXPECT_LT(worst_A, offset_A);
        const device::MotorParameters &motor = file.motor.front();
        const Vector3 torque_Nm = Vector3::Constant(motor.torque_constant_Nm_per_A * offset_A *
                                                    motor.resistance_Ohm / dR_Ohm);
        const Matrix3 J = device::motor_jacobian(
            file.geometry, device::joint_angles_rad(file.geometry, kStart_m).value());
        EXPECT_LT(worst_N, (J.inverse().transpose().cwiseAbs() * torque_Nm).norm());
        EXPECT_GT(unobserved_N, 0.1); // or there is nothing to see
    }
}

// What happens meanwhile must not be taken for one period, and the force must not step: R̂ i is a
// voltage, which at the peak current changes by no more than 50 V/s. R(θ) of the moving rotor adds
// its ripple, whose deviation ripples, too.
TEST(WindingObservers, MayBeSwitchedOffAndOnWhileTouching) {
    const device::DeviceDescription file = testing::phantom_1_0();
    for (const int off_ticks : {0, 1, 3, 10, 40, 400}) {
        for (int seed = 1; seed <= testing::cases(4, 100); ++seed) {
            const Touch touch{.dR_Ohm = 0.2, .duration_s = 4.0};
            TouchedDevice device(touch, seed);
            Vector3 R_hat_Ohm = Vector3::Zero();
            Vector3 theta_rad = Vector3::Zero();
            for (int tick = 0; tick < 5500; ++tick) {
                const double time_s = tick * touch.period_s;
                device.rig.inputs.observes_resistance =
                    tick % 1000 < 400 || tick % 1000 >= 400 + off_ticks;
                device.run_to(time_s);
                const servo::ServoSample &last = device.rig.last;
                ASSERT_FALSE(device.rig.has_tripped()) << description(last.safety);
                const Vector3 change_Ohm = last.command.cancelled_resistance_Ohm - R_hat_Ohm;
                const Vector3 turned_rad = last.theta_rad - theta_rad;
                for (std::size_t motor = 0; motor < 3; ++motor) {
                    const auto j = static_cast<Eigen::Index>(motor);
                    const device::MotorParameters &its = file.motor[motor];
                    ASSERT_TRUE(last.motor[motor].is_trusted)
                        << off_ticks << " off, device " << seed << ", motor " << motor << " at "
                        << time_s << (last.winding[motor].is_contradicted ? ", contradicted" : "");
                    if (last.command.mode != device::CommandMode::drive || last.safety.ramp < 1.0) {
                        continue;
                    }
                    const double ripple_Ohm = its.commutation_ripple * its.resistance_Ohm *
                                              its.commutator_segments * std::abs(turned_rad[j]);
                    EXPECT_LT(std::abs(change_Ohm[j]),
                              kMaxChange_V_per_s * kPeriod_s / its.peak_current_A +
                                  1.5 * ripple_Ohm + 1e-4)
                        << off_ticks << " off, device " << seed << ", motor " << motor << " at "
                        << time_s;
                    ASSERT_GT(device.dR_Ohm(motor), 0.0) << seed << ' ' << time_s;
                }
                R_hat_Ohm = last.command.cancelled_resistance_Ohm;
                theta_rad = last.theta_rad;
            }
        }
    }
}

/// Values in use, without a device behind them: the winding is at rest.
struct AtRest {
    explicit AtRest(const device::DeviceDescription &description)
        : device(description), observers(description, 0.0, kPeriod_s) {}

    /// Advances by a tick; returns by how much R̂ for dR 0.2 Ω and V_b moved most.
    double tick() {
        const control::ObservedMotors before = observers.motors();
        observers.update({}, Vector3::Zero(), true, 0);
        observers.record(device::DeviceCommand::braking());
        double moved = 0.0;
        for (std::size_t j = 0; j < before.size(); ++j) {
            const control::ObservedMotor &now = observers.motors()[j];
            const auto R_hat_Ohm = [&](const control::ObservedMotor &motor) {
                return control::cancelled_resistance_Ohm(device.motor[j], motor, 0.2);
            };
            moved = std::max({moved, std::abs(R_hat_Ohm(now) - R_hat_Ohm(before[j])),
                              std::abs(now.brush_voltage_V - before[j].brush_voltage_V)});
        }
        return moved;
    }

    double run(int ticks) {
        double moved = 0.0;
        for (int i = 0; i < ticks; ++i) {
            moved = std::max(moved, tick());
        }
        return moved;
    }

    device::DeviceDescription device;
    WindingObservers observers;
};

// What is known of two motors and not of the third would turn the force.
TEST(WindingObservers, DistrustOfOneMotorIsOfAllThreeAndIsRecoveredFrom) {
    device::DeviceDescription calibrated = testing::phantom_1_0();
    device::Calibration calibration = testing::possible_calibration("A1");
    for (std::size_t j = 0; j < 3; ++j) {
        device::MotorCalibration &motor = calibration.motor[j];
        motor.resistance_Ohm = 2.18 * (0.97 + 0.03 * static_cast<double>(j));
        motor.resistance_deviation_Ohm = 0.002;
        motor.torque_constant_Nm_per_A = 23.4e-3 * (1.02 - 0.01 * static_cast<double>(j));
    }
    calibrated.calibration = calibration;
    const device::DeviceDescription file = testing::phantom_1_0();
    const double bound_Ohm = max_resistance_change_Ohm_per_s(file) * kPeriod_s;
    for (std::size_t distrusted = 0; distrusted < 3; ++distrusted) {
        AtRest rest(calibrated);
        rest.run(2000);
        const control::ObservedMotors known = rest.observers.motors();
        rest.observers.distrust(distrusted);
        EXPECT_LE(rest.run(2000), bound_Ohm + 1e-12);
        for (std::size_t j = 0; j < 3; ++j) {
            const control::ObservedMotor &now = rest.observers.motors()[j];
            const control::ObservedMotor expected = used_at_start(file, j);
            EXPECT_EQ(now.is_trusted, j != distrusted);
            EXPECT_NEAR(now.here.resistance_Ohm, expected.here.resistance_Ohm, 1e-12);
            EXPECT_NEAR(now.mean.deviation_Ohm, expected.mean.deviation_Ohm, 1e-12);
            EXPECT_EQ(now.torque_constant_Nm_per_A, file.motor[j].torque_constant_Nm_per_A);
            EXPECT_EQ(now.offset_A, 0.0);
            EXPECT_EQ(now.brush_voltage_V, expected.brush_voltage_V);
            EXPECT_GT(std::abs(known[j].here.resistance_Ohm - now.here.resistance_Ohm),
                      j == 1 ? 0.0 : 0.02); // or there is nothing to see
        }
        rest.observers.restart();
        EXPECT_LE(rest.run(2000), bound_Ohm + 1e-12);
        for (std::size_t j = 0; j < 3; ++j) {
            const control::ObservedMotor &now = rest.observers.motors()[j];
            EXPECT_TRUE(now.is_trusted);
            EXPECT_NEAR(now.here.resistance_Ohm, known[j].here.resistance_Ohm, 1e-3);
            EXPECT_EQ(now.torque_constant_Nm_per_A, known[j].torque_constant_Nm_per_A);
        }
    }
}

// While R becomes known, when a motor is distrusted, and when all are observed anew, K_P follows
// dR. What the voltage of the law moves by is compared with the law for the same state and what was
// known a tick before.
TEST(WindingObservers, NoVoltageStepsWhenMotorsBecomeKnownOrAreDistrusted) {
    const control::HapticLaw law(testing::phantom_1_0());
    for (const double delay_periods : {0.0, 1.0}) {
        for (const double dR_Ohm : {0.2, 0.5}) {
            Touch touch{.dR_Ohm = dR_Ohm, .duration_s = 8.0, .depth_m = 0.005};
            touch.delay_periods = delay_periods;
            touch.has_brushes = false;
            TouchedDevice device(touch, 3);
            double fastest_V_per_s = 0.0;
            Vector3 largest_dR_Ohm = Vector3::Zero();
            Vector3 smallest_dR_Ohm = Vector3::Constant(10.0);
            int distrusted_ticks = 0;
            bool was_distrusted = false;
            servo::ServoSample before;
            for (int tick = 0; tick < 9000; ++tick) {
                if (tick == 4000) {
                    device.rig.device().commit(
                        {.kind = device::FaultKind::current_gain, .size = Vector3(0.0, 0.5, 0.0)});
                }
                was_distrusted = was_distrusted || !device.known(1).is_trusted;
                if (was_distrusted && ++distrusted_ticks == 500) {
                    device.rig.device().clear_fault();
                }
                device.rig.inputs.observes_resistance =
                    distrusted_ticks < 1000 || distrusted_ticks > 1200;
                device.run_to(1e-3 * tick);
                const servo::ServoSample &now = device.rig.last;
                ASSERT_FALSE(device.rig.has_tripped()) << description(now.safety);
                if (before.contact.touching && now.contact.touching && now.safety.ramp == 1.0) {
                    const control::Configuration state =
                        law.configuration(now.theta_rad, now.theta_rate_rad_per_s);
                    const auto e_W_V = [&](const control::ObservedMotors &motors) {
                        return law(state, now.contact, now.tuning, {now.global_alpha_rad2_per_m2},
                                   motors, now.lag_s)
                            .command.e_W_V;
                    };
                    // R(θ) of the moving rotor is no change of what is known.
                    control::ObservedMotors then = before.motor;
                    for (std::size_t j = 0; j < 3; ++j) {
                        const double turned_rad =
                            std::abs(now.theta_rad[static_cast<Eigen::Index>(j)] -
                                     before.theta_rad[static_cast<Eigen::Index>(j)]);
                        if (turned_rad > 0.02) {
                            then[j] = now.motor[j];
                        }
                    }
                    fastest_V_per_s = std::max(
                        fastest_V_per_s,
                        (e_W_V(now.motor) - e_W_V(then)).cwiseAbs().maxCoeff() / kPeriod_s);
                    largest_dR_Ohm = largest_dR_Ohm.cwiseMax(now.dR_Ohm);
                    smallest_dR_Ohm = smallest_dR_Ohm.cwiseMin(now.dR_Ohm);
                }
                before = now;
            }
            EXPECT_GT(distrusted_ticks, 2000);
            EXPECT_LE(fastest_V_per_s, kMaxChange_V_per_s);
            EXPECT_GT(largest_dR_Ohm.minCoeff(), 1.3 * smallest_dR_Ohm.maxCoeff());
            std::printf("worst at %g Ω, d %g: %.1f V/s; dR %.2f to %.2f Ω, distrusted after %d\n",
                        dR_Ohm, delay_periods, fastest_V_per_s, smallest_dR_Ohm.minCoeff(),
                        largest_dR_Ohm.maxCoeff(), 9000 - distrusted_ticks);
        }
    }
}

// In fast free motion the current goes with the acceleration, and so would an error of the mean
// current that does.
TEST(WindingObservers, FastFreeMotionTeachesNothingWrong) {
    constexpr double kSwing_s = 10.0;
    constexpr double kStep_s = 0.01;
    for (const auto &[servo_hz, delay_periods] :
         {std::pair(500.0, 0.0), {1000.0, 0.0}, {1000.0, 0.4}, {1000.0, 1.0}, {4000.0, 2.5}}) {
        for (const double dR_Ohm : {0.5, 0.2}) {
            for (int seed = 1; seed <= testing::cases(1, 10); ++seed) {
                Touch touch;
                touch.dR_Ohm = dR_Ohm;
                touch.period_s = 1.0 / servo_hz;
                touch.delay_periods = delay_periods;
                touch.has_brushes = false;
                simulated::SimulationOptions simulation = options(touch, seed);
                std::vector<simulated::HandPath::Point> points{{0.0, kStart_m},
                                                               {kBeforeTouch_s, kStart_m}};
                for (int i = 1; i <= std::lround(kSwing_s / kStep_s); ++i) {
                    const double time_s = i * kStep_s;
                    const double away = std::min({1.0, time_s, kSwing_s - time_s}); // 1 s each
                    const double phase = 2.0 * std::numbers::pi * 1.2 * time_s;
                    const Vector3 swing_m(0.035 * std::sin(phase), 0.03 * std::sin(1.1 * phase),
                                          0.03 * std::sin(0.9 * phase));
                    points.push_back(
                        {kBeforeTouch_s + time_s, kStart_m + away * (0.06 * normal() + swing_m)});
                }
                const double begin_s = kBeforeTouch_s + kSwing_s + 0.5;
                points.push_back({begin_s, kStart_m});
                add_touch(touch, begin_s, points);
                simulation.path.emplace(std::move(points));
                TouchedDevice device(touch, simulation);
                device.run_to(begin_s + 2.0);
                for (const control::ObservedMotor &motor : device.rig.last.motor) {
                    EXPECT_TRUE(motor.is_trusted);
                }
                EXPECT_LT(worst_error(device, touch, begin_s + 2.0, begin_s + touch.duration_s),
                          dR_Ohm > 0.3 ? 0.02 : 0.05)
                    << servo_hz << " Hz, delay " << delay_periods << ", " << dR_Ohm << " Ω, device "
                    << seed;
            }
        }
    }
}

// A hand that taps the plane at 0.3 m/s stops within a period or two.
TEST(WindingObservers, TapsAreNoFaults) {
    for (int seed = 1; seed <= 5; ++seed) {
        simulated::SimulationOptions simulation = options({}, seed);
        std::vector<simulated::HandPath::Point> points;
        for (int i = 0; i < 1000; ++i) {
            const double time_s = 0.005 * i;
            const double phase = 2.0 * std::numbers::pi * 8.0 * (time_s - kBeforeTouch_s);
            const double up_m = time_s < kBeforeTouch_s ? 0.0 : 0.006 * (std::cos(phase) - 1.0);
            points.push_back({time_s, kStart_m + up_m * normal()});
        }
        simulation.path.emplace(std::move(points));
        TouchedDevice device({}, simulation);
        bool has_touched = false;
        for (int tick = 0; tick < 5000; ++tick) {
            const double time_s = 1e-3 * tick;
            device.run_to(time_s);
            has_touched = has_touched || device.rig.last.contact.touching;
            ASSERT_FALSE(device.rig.has_tripped()) << description(device.rig.last.safety);
            for (std::size_t motor = 0; motor < 3; ++motor) {
                ASSERT_TRUE(device.known(motor).is_trusted) << seed << ' ' << time_s;
            }
        }
        EXPECT_TRUE(has_touched);
    }
}

// Brushes and bridge drop a voltage with the current's sign, which is taken for a resistance that
// is not there: strokes in free space with 10 mV left −0.17 Ω after three seconds at dR 0.2 Ω, and
// the tip pushed with 10.5 N.
TEST(WindingObservers, BrushesLeaveAResistance) {
    double least_Ohm = 10.0;
    double largest_N = 0.0;
    double largest_A = 0.0;
    int runs = 0;
    for (const auto &[brush_V, brush_A] :
         {std::pair(0.01, 0.03), {0.01, 0.01}, {0.05, 0.03}, {0.1, 0.03}}) {
        for (const double dR_Ohm : {0.2, 0.5}) {
            for (int seed = 0; seed < testing::cases(2, 100); ++seed, ++runs) {
                Touch touch;
                touch.dR_Ohm = dR_Ohm;
                touch.air_C = seed == 0 ? 25.0 : 15.0 + 5.0 * (seed % 5);
                simulated::SimulationOptions simulation = options(touch, seed);
                simulation.brush_voltage_V = brush_V;
                simulation.brush_current_A = brush_A;
                simulation.path.reset();
                TouchedDevice device(touch, simulation);
                device.rig.inputs.surface = nullptr;
                const device::DeviceDescription file = testing::phantom_1_0();
                const Vector3 k_T = control::torque_constants(file);
                for (int tick = 0; tick < 11200; ++tick) {
                    const double s = std::max(0.0, 1e-3 * tick - 1.2);
                    device.rig.phantom().set_hand_target(
                        kStart_m + Vector3(0.05 * std::sin(6.0 * s), 0.04 * std::sin(5.1 * s),
                                           0.03 * std::sin(6.9 * s)));
                    device.run_to(1e-3 * tick);
                    const testing::TipAt tip(file.geometry, device.rig.truth().theta_rad);
                    largest_A =
                        std::max(largest_A, device.rig.truth().current_A.cwiseAbs().maxCoeff());
                    largest_N = std::max(
                        largest_N,
                        tip.force_N(k_T.cwiseProduct(device.rig.truth().current_A)).norm());
                    for (std::size_t motor = 0; motor < 3; ++motor) {
                        least_Ohm = std::min(least_Ohm, device.dR_Ohm(motor));
                    }
                }
                EXPECT_FALSE(device.rig.has_tripped()) << description(device.rig.last.safety);
            }
        }
    }
    EXPECT_GT(least_Ohm, 0.0);
    EXPECT_LT(largest_N, 1.0);
    std::printf("worst of %d: %.3f Ω left, %.2f A and %.2f N in free space\n", runs, least_Ohm,
                largest_A, largest_N);
}

/// A fault of one or all motors' converters; the amplifier's own sensor has none, which is the
/// worse case: R̂ is applied in full to what the servo misjudges.
device::Fault any_sensor_fault(std::mt19937_64 &random) {
    std::uniform_real_distribution<double> any(-1.0, 1.0);
    const auto motor = std::uniform_int_distribution<Eigen::Index>(0, 2)(random);
    const auto kind = std::uniform_int_distribution<int>(0, 4)(random);
    const bool are_all = any(random) < 0.0;
    device::Fault fault{.kind = device::FaultKind::current_reading}; // none: of no motor
    const auto set = [&](device::FaultKind of, double size) {
        fault.kind = of;
        if (are_all) {
            fault.size.setConstant(size);
        } else {
            fault.size[motor] = size;
        }
    };
    switch (kind) {
    case 0:
        set(device::FaultKind::current_reading, any(random)); // stuck
        break;
    case 1:
        set(device::FaultKind::current_offset, 0.1 * any(random));
        break;
    case 2:
        set(device::FaultKind::current_drift, 1e-4 * any(random)); // up to 0.1 A in a second
        break;
    case 3:
        set(device::FaultKind::current_gain, 0.05 * any(random));
        break;
    default:
        break;
    }
    return fault;
}

// R differs from the file's by up to a fifth, which is more than the file says; the air has any
// temperature, the commutator any phase. The hand touches, or never does, or holds still.
TEST(WindingObservers, NeverCancelMoreThanThereIs) {
    const int runs = testing::cases(40, 1000);
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> any(0.0, 1.0);
    double least_Ohm = 10.0;
    int trips = 0;
    for (int run = 0; run < runs; ++run) {
        Touch touch;
        touch.dR_Ohm = 0.1 + 0.9 * any(random);
        touch.duration_s = 4.0;
        touch.depth_m = any(random) < 0.2 ? -0.002 : 0.002 + 0.004 * any(random);
        touch.stroke_m = any(random) < 0.3 ? 0.0 : 0.03 * any(random);
        touch.air_C = 15.0 + 20.0 * any(random);
        simulated::SimulationOptions simulation = options(touch, run + 1);
        simulation.effects.motor_tolerances = false; // R is drawn here, k_T is the file's
        for (double &share : simulation.resistance_share) {
            share = 0.8 + 0.4 * any(random);
        }
        TouchedDevice device(touch, simulation);
        // Often when little is known yet.
        const double fault_s =
            any(random) < 0.5 ? kBeforeTouch_s + 0.7 * any(random) : 5.0 * any(random);
        device::Fault fault = any_sensor_fault(random);
        fault.begin_s = std::floor(fault_s / touch.period_s);
        device.rig.device().commit(fault);
        for (int tick = 0; tick < 5500; ++tick) {
            const double time_s = tick * touch.period_s;
            device.run_to(time_s);
            if (device.rig.last.command.mode != device::CommandMode::drive) {
                continue;
            }
            for (std::size_t motor = 0; motor < 3; ++motor) {
                least_Ohm = std::min(least_Ohm, device.dR_Ohm(motor));
                ASSERT_GT(device.dR_Ohm(motor), 0.0)
                    << "run " << run << ", motor " << motor << " at " << time_s << " s, fault at "
                    << fault_s << "; R " << device.seen_Ohm(motor) << " Ω, taken for "
                    << device.known(motor).here.resistance_Ohm << " ± "
                    << device.known(motor).here.deviation_Ohm << " Ω, R-hat limited to "
                    << device.rig.last.winding[motor].R_hat_limit_Ohm << " Ω";
            }
        }
        trips += device.rig.has_tripped() ? 1 : 0;
    }
    std::printf("worst of %d: %.3f Ω left; %d trips\n", runs, least_Ohm, trips);
}

} // namespace
} // namespace springdrive::servo
