#include "engine/study/protocol/checks.h"

#include "base/degrees.h"
#include "base/vector.h"
#include "device/core/phantom/kinematics.h"
#include "engine/study/protocol/presented_stimulus.h"

#include <Eigen/LU>

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace springdrive::study {

namespace {

double angle_deg(const Vector3 &a, const Vector3 &b) {
    return kDegreesPerRadian * std::atan2(a.cross(b).norm(), a.dot(b));
}

double of_pulse_deg(const device::DeviceDescription &device, const Matrix3 &J,
                    const Condition &condition, const Vector3 &direction) {
    const Matrix3 to_tip = J.transpose().inverse();
    const double impulse_Ns = 0.5 * condition.pulse_N / condition.pulse_hz;
    double most_deg = 0.0;
    for (Eigen::Index j = 0; j < 3; ++j) {
        const device::MotorParameters &motor = device.motor[static_cast<std::size_t>(j)];
        const double dR_Ohm = device::residual_resistance_Ohm(motor, condition.tuning.dR_Ohm);
        const double count_Nms = motor.torque_constant_Nm_per_A * motor.torque_constant_Nm_per_A *
                                 device.rad_per_count() / dR_Ohm;
        const Vector3 count_Ns = count_Nms * to_tip.col(j);
        const Vector3 across_Ns = count_Ns - count_Ns.dot(direction) * direction;
        most_deg = std::max(most_deg, kDegreesPerRadian * std::atan2(across_Ns.norm(), impulse_Ns));
    }
    return most_deg;
}

double of_press_deg(const device::DeviceDescription &device, const Vector3 &q_rad,
                    const Vector3 &force_N) {
    const auto J_at = [&](const Vector3 &at_rad) {
        return device::motor_jacobian(device.geometry, at_rad);
    };
    const Vector3 torque_Nm = J_at(q_rad).transpose() * force_N;
    double most_deg = 0.0;
    for (Eigen::Index j = 0; j < 3; ++j) {
        const Vector3 count_rad = device.rad_per_count() * Vector3::Unit(j);
        const Vector3 turned_rad = q_rad + device::joint_from_motor(device.geometry, count_rad);
        most_deg = std::max(most_deg,
                            angle_deg(J_at(turned_rad).transpose().inverse() * torque_Nm, force_N));
    }
    return most_deg;
}

} // namespace

double count_angle_deg(const Protocol &protocol, const StudySetting &setting,
                       const Presented &presented) {
    const bool is_pulse = protocol.stimulus == StimulusForm::pulse;
    if (!is_pulse && protocol.stimulus != StimulusForm::press) {
        return 0.0;
    }
    const std::optional<PredictedPress> press =
        predicted_press(setting, presented, protocol.stimulus);
    if (!press) {
        return 0.0;
    }
    if (!is_pulse) {
        return of_press_deg(setting.device, press->q_rad, press->held_N);
    }
    const Stimulus stimulus = stimulus_of(protocol, setting, presented);
    return of_pulse_deg(setting.device,
                        device::motor_jacobian(setting.device.geometry, press->q_rad),
                        presented.parameters, stimulus.direction);
}

ProtocolFindings check_marking(const Protocol &protocol, const StudySetting &setting,
                               const std::vector<Presented> &presented) {
    std::vector<StimulusFinding> all;
    const double band_deg = protocol.marking.direction_deg;
    for (const Presented &one : presented) {
        const PlacedCondition &place = setting.conditions[one.condition];
        const bool is_told = place.surface != nullptr && place.problem.empty() &&
                             intended_measures(protocol, setting, one).turn_deg.has_value();
        const double count_deg = is_told ? count_angle_deg(protocol, setting, one) : 0.0;
        if (count_deg > band_deg) {
            all.push_back(
                {one.condition,
                 {Severity::warning, name_of(protocol, one),
                  fmt::format("has a band of {:g}° for its direction, of which one encoder count "
                              "is {:.2g}°: trials will be marked by chance",
                              band_deg, count_deg),
                  fmt::format("raise marking.direction_deg to {:.2g} or more, raise pulse_N, or "
                              "lower pulse_hz",
                              std::ceil(10.0 * count_deg) / 10.0)}});
        }
    }
    return once_per_condition(all);
}

} // namespace springdrive::study
