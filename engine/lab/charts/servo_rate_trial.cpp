#include "engine/lab/charts/servo_rate_trial.h"

#include "base/input_error.h"
#include "engine/control/motion_control.h"
#include "engine/control/perception.h"
#include "engine/lab/loops/direction_spectrum.h"
#include "engine/lab/loops/stability_case.h"
#include "engine/lab/loops/stiffness_ellipse.h"
#include "engine/lab/loops/stiffness_sweep.h"
#include "engine/lab/rig/scenario/scenarios.h"
#include "engine/lab/rig/servo_rig.h"
#include "engine/lab/rig/timing.h"

#include <cmath>
#include <complex>
#include <cstddef>
#include <numbers>
#include <vector>

namespace springdrive::charts {

namespace {

constexpr double kPeriod_s = 1e-3; ///< of the timed servo
constexpr std::size_t kTicks = 8000;

/// Joint angles in the middle of the workspace.
Vector3 middle_angles_rad(const device::DeviceDescription &device) {
    return device::joint_angles_rad(device.geometry, device.workspace.centre_m)
        .value_or(Vector3::Zero());
}

/// The servo's measurements, tick by tick.
std::vector<device::Measurement> recorded_states(rig::ServoRig &rig) {
    std::vector<device::Measurement> states;
    for (std::size_t i = 0; i < kTicks; ++i) {
        if (rig.tick(); rig.has_tripped()) {
            throw InputError("the safety monitor stopped the servo while it was timed: " +
                             servo::description(rig.last.safety) + "; choose another tuning");
        }
        states.push_back(rig.measured());
    }
    return states;
}

} // namespace

double stiffness_error(const loops::SpringDrive &drive, int points) {
    double sum = 0.0;
    const double ratio = kMaxJudged_Hz / kMinJudged_Hz;
    for (int i = 0; i < points; ++i) {
        const double asked_Hz = kMinJudged_Hz * std::pow(ratio, i / (points - 1.0));
        const loops::SweepWindow window = loops::sweep_window(asked_Hz, drive.period_s);
        const double omega_rad_per_s = 2.0 * std::numbers::pi * window.frequency_hz(drive.period_s);
        const std::complex<double> truth = loops::analytic_stiffness(drive, omega_rad_per_s);
        sum += std::norm((loops::measured_stiffness(drive, window) - truth) / truth);
    }
    return std::sqrt(sum / points);
}

double perceived_direction_error_rad(const device::DeviceDescription &device,
                                     const control::Tuning &tuning, double period_s) {
    const Vector3 q_rad = middle_angles_rad(device);
    loops::PlanarContact contact;
    contact.J = loops::planar_jacobian(device.geometry, q_rad);
    contact.alpha_rad2_per_m2 = loops::planar_stiffness(device, tuning, q_rad).alpha_rad2_per_m2;
    contact.relative_stiffness = control::relative_stiffness(device).tail<2>();
    for (std::size_t j = 0; j < 2; ++j) {
        contact.drive[j] = {device.motor[j + 1], tuning, period_s, 0};
    }
    return loops::worst_direction_error_rad(loops::tip_stiffness(
        contact, control::MotionMap::transpose, 2.0 * std::numbers::pi * control::kPerceived_Hz));
}

bool is_stable_on_all_motors(const device::DeviceDescription &device, const control::Tuning &tuning,
                             double period_s, double delay_periods) {
    loops::StabilityCase each = loops::motors_alone(device, tuning);
    each.period_s = period_s;
    each.delay_periods = delay_periods;
    return loops::is_stable(each);
}

rig::Cost cost_of_servo_tick(const ChartSetting &setting) {
    const rig::ScenarioSetting of_setting{setting.device, setting.tuning};
    rig::ServoRig rig(rig::scripted_touch_scenario(of_setting, rig::placed_sphere()));
    rig.inputs.global_alpha_rad2_per_m2 = control::global_alpha_bound(setting.device);
    const std::vector<device::Measurement> states = recorded_states(rig);
    return rig::cost_of(setting.repeats, static_cast<double>(states.size()), [&] {
        servo::ServoLoop loop(rig.phantom(), kPeriod_s);
        for (const device::Measurement &state : states) {
            rig::keep(loop.update(state, rig.inputs));
        }
    });
}

} // namespace springdrive::charts
