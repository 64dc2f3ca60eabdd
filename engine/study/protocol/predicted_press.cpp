#include "engine/study/protocol/predicted_press.h"

#include "device/core/hand_parameters.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/motion_control.h"
#include "engine/lab/loops/both_maps.h"
#include "engine/lab/loops/stability_case.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace springdrive::study {

namespace {

double active_alpha(const device::DeviceDescription &device, const control::Tuning &tuning,
                    const Matrix3 &J) {
    switch (tuning.alpha_mode) {
    case control::AlphaMode::global:
        return control::global_alpha_bound(device);
    case control::AlphaMode::by_hand:
        return tuning.alpha_rad2_per_m2;
    case control::AlphaMode::on_the_fly:
        break;
    }
    return control::alpha_bound(J, control::relative_stiffness(device));
}

/// The static stiffness of the tip under the condition's map.
std::optional<Matrix3> static_stiffness(const device::DeviceDescription &device,
                                        const PlacedCondition &place, const Condition &condition,
                                        const Vector3 &q_rad, const Matrix3 &J) {
    control::Tuning tuning = condition.tuning;
    const double surface_eta = condition.hold == Hold::cup ? 0.0 : place.surface_eta;
    tuning.eta = control::combined_eta(surface_eta, tuning.eta);
    const std::optional<loops::MapStiffness> both =
        loops::map_stiffness(device, tuning, q_rad, active_alpha(device, tuning, J));
    if (!both) {
        return std::nullopt;
    }
    return tuning.map == control::MotionMap::inverse
               ? both->inverse_N_per_m
               : Matrix3(both->transpose_N_per_m * Matrix3::Identity());
}

double normal_force_N(const device::DeviceDescription &device, const Condition &condition,
                      StimulusForm form, const PredictedPress &press, const Vector3 &normal) {
    switch (form) {
    case StimulusForm::press:
        return condition.press_N;
    case StimulusForm::pulse:
        return condition.press_N + condition.pulse_N;
    case StimulusForm::blow: {
        const double mass_kg =
            device::HandParameters{}.mass_kg + tip_mass_kg(device, press.q_rad, normal);
        return condition.speed_m_per_s * std::sqrt(press.stiffness_N_per_m * mass_kg);
    }
    case StimulusForm::stroke:
        break;
    }
    return 0.0;
}

} // namespace

double tip_mass_kg(const device::DeviceDescription &device, const Vector3 &q_rad,
                   const Vector3 &direction) {
    loops::StabilityCase which;
    which.device = device;
    which.q_rad = q_rad;
    which.freedom = loops::Freedom::three_motors;
    const Matrix3 M = loops::driven_load(which, {0, loops::no_hand()}).inertia_kg_m2;
    const Matrix3 J = device::motor_jacobian(device.geometry, q_rad);
    return 1.0 / direction.dot(J * M.inverse() * J.transpose() * direction);
}

std::optional<PredictedPress> predicted_press(const device::DeviceDescription &device,
                                              const PlacedCondition &place,
                                              const Condition &condition, StimulusForm form) {
    const Vector3 normal = place.spot.normal;
    const std::optional<Vector3> q_rad =
        device::joint_angles_rad(device.geometry, place.spot.point_m);
    if (!q_rad || form == StimulusForm::stroke) {
        return std::nullopt;
    }
    PredictedPress press;
    press.q_rad = *q_rad;
    const Matrix3 J = device::motor_jacobian(device.geometry, *q_rad);
    const std::optional<Matrix3> K = static_stiffness(device, place, condition, *q_rad, J);
    if (!K || !(normal.dot(*K * normal) > 0.0)) {
        return std::nullopt;
    }
    press.stiffness_N_per_m = normal.dot(*K * normal);
    const double pressed_N = normal_force_N(device, condition, form, press, normal);
    // A force that is turned by φ has only cos φ of it against the hand's press.
    const Vector3 turn = turned(condition, normal);
    press.depth_m = pressed_N / (press.stiffness_N_per_m * std::max(0.1, turn.dot(normal)));
    const Vector3 straight_N = press.depth_m * (*K * normal);
    press.force_N = condition.turn_deg == 0.0 ? straight_N : Vector3(straight_N.dot(normal) * turn);
    press.current_A =
        (J.transpose() * press.force_N).cwiseQuotient(control::torque_constants(device));
    press.held_energy_J = 0.5 * press.depth_m * straight_N.dot(normal);
    return press;
}

double pulse_energy_J(const device::DeviceDescription &device, const PredictedPress &press,
                      const Condition &condition) {
    const loops::Hand light = loops::hand_of_firmness(0.0);
    const double mass_kg =
        light.mass_kg + tip_mass_kg(device, press.q_rad, press.force_N.normalized());
    const double impulse_Ns = 0.5 * condition.pulse_N / condition.pulse_hz; // of (1 − cos)/2
    return std::min(0.5 * impulse_Ns * impulse_Ns / mass_kg,
                    0.5 * condition.pulse_N * condition.pulse_N / light.stiffness_N_per_m);
}

} // namespace springdrive::study
