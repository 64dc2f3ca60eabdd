// Servo samples made up with known stiffness, force and position: a device in one pose.
#pragma once

#include "device/core/phantom/kinematics.h"
#include "engine/control/motion_control.h"
#include "engine/servo/servo_inputs.h"
#include "engine/study/stimuli/delivery_meter.h"
#include "tests/support/devices.h"

#include <Eigen/LU>

namespace springdrive::study::made_up {

inline constexpr double kPeriod_s = 1e-3;
inline const Vector3 kSpot_m(0.0, -0.005, -0.015); ///< of the pose, below the start

/// A run and its meter, fed with samples.
class MadeUpTrial {
public:
    explicit MadeUpTrial(const Stimulus &stimulus)
        : device(testing::phantom_1_0()), run(device, stimulus, kPeriod_s),
          meter(device, stimulus, kPeriod_s) {
        const Vector3 q_rad = *device::joint_angles_rad(device.geometry, kSpot_m);
        sample.theta_rad = device::motor_from_joint(device.geometry, q_rad);
        J = device::motor_jacobian(device.geometry, q_rad);
        sample.motor = control::motors_of_file(device.motor);
        sample.safety.state = servo::SafetyState::running;
        sample.alpha_bound_rad2_per_m2 = 5000.0;
        for (Eigen::Index j = 0; j < 3; ++j) {
            sample.command.cancelled_resistance_Ohm[j] =
                device.motor[static_cast<std::size_t>(j)].resistance_Ohm - kResidual_Ohm;
        }
        sample.tip_m = stimulus.start_m;
        sample.contact.x0_m = stimulus.start_m;
    }

    static constexpr double kResidual_Ohm = 0.5;

    void tick() {
        run.update(sample, inputs);
        meter.take(sample, run);
        sample.time_s += kPeriod_s;
    }
    void ticks(double seconds) {
        for (long i = std::lround(seconds / kPeriod_s); i > 0; --i) {
            tick();
        }
    }
    /// At rest at the start until it may approach.
    void rest() {
        while (run.phase() == StimulusPhase::waiting && sample.time_s < 30.0) {
            tick();
        }
    }
    void touch(const Vector3 &x0_m) {
        sample.contact.touching = true;
        sample.contact.x0_m = x0_m;
    }
    void lift() { sample.contact.touching = false; }

    /// The force on the tip at rest that a voltage beyond the law's makes: J⁻ᵀ k_T V/dR.
    [[nodiscard]] Vector3 force_of_N(const Vector3 &voltage_V) const {
        return J.transpose().inverse() * control::torque_constants(device).cwiseProduct(voltage_V) /
               kResidual_Ohm;
    }

    device::DeviceDescription device;
    Matrix3 J;
    servo::ServoSample sample;
    servo::ServoInputs inputs;
    StimulusRun run;
    DeliveryMeter meter;
};

inline Stimulus press_of_a_second() {
    Stimulus stimulus;
    stimulus.start_m = Vector3(0.0, 0.015, -0.015);
    stimulus.rest_s = 0.5;
    stimulus.approach_s = 1.0;
    stimulus.presentation_s = 1.0;
    return stimulus;
}

} // namespace springdrive::study::made_up
