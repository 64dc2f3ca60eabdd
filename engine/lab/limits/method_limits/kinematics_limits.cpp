#include "engine/lab/limits/method_limits/limit_trials.h"

#include "base/degrees.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/haptic_law.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace springdrive::limits {

namespace {

constexpr const char *kKinematicsMethod = "inverse kinematics (18)";
constexpr double kStraight_deg = 90.0; ///< where the links are aligned
constexpr double kTimes = 5.0;         ///< the amplification that counts as a failure
constexpr double kWay_m = 1e-7;        ///< so short that the map is linear

/// With l₁ = l₂ and N₂ = N₃ there are closed forms.
std::optional<double> if_links_are_even(const device::DeviceDescription &device, double predicted) {
    const device::PhantomGeometry &geometry = device.geometry;
    const bool even = geometry.upper_arm_m == geometry.forearm_m &&
                      geometry.transmission_ratio[1] == geometry.transmission_ratio[2];
    return even ? std::optional(predicted) : std::nullopt;
}

control::Configuration at_rest(const device::DeviceDescription &device, const Vector3 &q_rad) {
    return control::HapticLaw(device).configuration(
        device::motor_from_joint(device.geometry, q_rad), Vector3::Zero());
}

/// The largest displacement of the motors' set-point per displacement of the tip's, over directions
/// in the links' plane [rad/m]; infinite where (18) has no solution for one of them. The upper arm
/// is level.
double set_point_reach(const device::DeviceDescription &device, double fold_deg, double way_m) {
    constexpr int kDirections = 720;
    const control::Configuration now =
        at_rest(device, Vector3(0.0, 0.0, fold_deg / kDegreesPerRadian));
    double maximum = 0.0;
    for (int i = 0; i < kDirections; ++i) {
        const double angle = 2.0 * std::numbers::pi * i / kDirections;
        const control::TipSetPoint target{
            now.tip_m + way_m * Vector3(0.0, std::cos(angle), std::sin(angle)), Vector3::Zero()};
        const std::optional<control::MotorSetPoint> found =
            control::inverse_map(device.geometry, now, target);
        maximum = std::max(maximum,
                           found ? (found->theta_Sd_rad - now.theta_rad).norm() / way_m : HUGE_VAL);
    }
    return maximum;
}

/// Near q₃ − q₂ = 90° J⁻¹ grows without bound: the smallest singular value of J is l √(1 − |sin(q₃
/// − q₂)|)/N with l₁ = l₂ = l and N₂ = N₃ = N.
LimitTrial exploding(const device::DeviceDescription &device) {
    const double square = set_point_reach(device, 0.0, kWay_m);
    return {
        {kKinematicsMethod,
         "q₃ − q₂ above",
         "°",
         "set-points move 5 times as far as at q₃ = q₂",
         if_links_are_even(device, kDegreesPerRadian * std::asin(1.0 - 1.0 / (kTimes * kTimes))),
         {},
         {}},
        0.0,
        kStraight_deg,
        false,
        [=](double fold_deg) {
            return set_point_reach(device, fold_deg, kWay_m) < kTimes * square;
        }};
}

/// A set-point beyond the reach of both links, l √(2 (1 + sin(q₃ − q₂))) from the shoulder.
LimitTrial unreachable(const device::DeviceDescription &device) {
    constexpr double kOut_m = 1e-3;
    const double share = 2.0 - kOut_m / device.geometry.upper_arm_m;
    return {
        {kKinematicsMethod,
         "q₃ − q₂ above",
         "°",
         "a set-point 1 mm away is out of reach",
         if_links_are_even(device, kDegreesPerRadian * std::asin(0.5 * share * share - 1.0)),
         {},
         {}},
        0.0,
        kStraight_deg,
        false,
        [=](double fold_deg) { return std::isfinite(set_point_reach(device, fold_deg, kOut_m)); }};
}

/// How far the base's set-point turns for a sideways displacement, at r = l₁ cos q₂, with the
/// forearm hanging down [rad].
double turn_rad(const device::DeviceDescription &device, double r_m) {
    const double l1_m = device.geometry.upper_arm_m;
    const control::Configuration now =
        at_rest(device, Vector3(0.0, std::acos(std::min(1.0, r_m / l1_m)), 0.0));
    const std::optional<control::MotorSetPoint> found = control::inverse_map(
        device.geometry, now, {now.tip_m + kWay_m * Vector3::UnitX(), Vector3::Zero()});
    return found ? std::abs(found->theta_Sd_rad[0] - now.theta_rad[0]) : HUGE_VAL;
}

/// Near the base's axis a sideways set-point turns the base far: N/r.
LimitTrial base_axis(const device::DeviceDescription &device) {
    const double l1_mm = 1e3 * device.geometry.upper_arm_m;
    const double usual_rad = turn_rad(device, device.geometry.upper_arm_m);
    return {{kKinematicsMethod,
             "r below",
             "mm",
             "the base's set-point moves 5 times as far as at r = l₁",
             l1_mm / kTimes,
             {},
             {}},
            l1_mm,
            0.1 * l1_mm,
            false,
            [=](double r_mm) { return turn_rad(device, 1e-3 * r_mm) < kTimes * usual_rad; }};
}

} // namespace

std::vector<LimitTrial> inverse_trials(const device::DeviceDescription &device) {
    return {exploding(device), unreachable(device), base_axis(device)};
}

} // namespace springdrive::limits
