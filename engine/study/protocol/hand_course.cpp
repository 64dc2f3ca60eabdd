#include "engine/study/protocol/hand_course.h"

#include "device/core/hand_parameters.h"
#include "device/core/phantom/dynamics.h"
#include "device/core/phantom/kinematics.h"
#include "engine/study/protocol/predicted_press.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace springdrive::study {

namespace {

constexpr double kDown_s = 0.5; ///< from the start to the touch
constexpr double kTouch_m =
    0.001;                        ///< deep: until there it does not know how far it will have to go
constexpr double kSettle_s = 0.2; ///< from there to the press
constexpr double kBack_s = 0.3;
constexpr double kLater_s = 0.05;         ///< so much longer, to be sure that it is over
constexpr double kFollowThrough_m = 0.01; ///< of a blow

/// What holds the linkage against its weight, at the tip [N].
Vector3 holding_N(const device::DeviceDescription &device, const Vector3 &q_rad) {
    const Vector3 weight_Nm = device::gravity_torque_Nm(
        device::linkage_moments(device.geometry, device.inertia, 0.0), q_rad);
    return device::joint_jacobian(device.geometry, q_rad).transpose().inverse() * weight_Nm;
}

/// Down to where the hand's spring presses as hard as the condition asks.
HandCourse press_course(const StudySetting &setting, const Presented &presented,
                        const Stimulus &stimulus, const HandDeviation &hand) {
    const scene::TouchSpot &spot = setting.conditions[presented.condition].spot;
    const PredictedPress press =
        predicted_press(setting, presented, stimulus.form).value_or(PredictedPress{});
    const double press_N = hand.share * presented.parameters.press_N;
    const double K_hand = device::HandParameters{}.stiffness_N_per_m;
    const double deep_m =
        press_N / press.stiffness_N_per_m +
        (press_N - spot.normal.dot(holding_N(setting.device, press.q_rad))) / K_hand;
    const Vector3 above_m = stimulus.start_m + hand.aside_m;
    const Vector3 at_m = spot.point_m + hand.aside_m;
    const Vector3 pressing_m = at_m - deep_m * spot.normal;
    const Vector3 touching_m = at_m - std::min(deep_m, kTouch_m) * spot.normal;
    const double start_s = kServoStart_s + stimulus.rest_s;
    HandCourse course;
    course.from_s = start_s + kDown_s + kSettle_s;
    course.until_s = course.from_s + stimulus.presentation_s + kLater_s + glide_back_s(stimulus);
    course.is_held = true;
    course.points = {{0.0, above_m},
                     {start_s, above_m},
                     {start_s + kDown_s, touching_m},
                     {course.from_s, pressing_m},
                     {course.until_s, pressing_m},
                     {course.until_s + kBack_s, above_m}};
    return course;
}

/// At constant speed through the surface.
HandCourse blow_course(const StudySetting &setting, const Presented &presented,
                       const Stimulus &stimulus, const HandDeviation &hand) {
    const scene::TouchSpot &spot = setting.conditions[presented.condition].spot;
    const Vector3 above_m = stimulus.start_m + hand.aside_m;
    const Vector3 below_m = spot.point_m + hand.aside_m - kFollowThrough_m * spot.normal;
    HandCourse course;
    course.from_s = kServoStart_s + stimulus.rest_s;
    const double arrived_s = course.from_s + (kApproach_m + kFollowThrough_m) /
                                                 (hand.share * presented.parameters.speed_m_per_s);
    course.until_s = arrived_s + stimulus.presentation_s + kLater_s + glide_back_s(stimulus);
    course.points = {{0.0, above_m},
                     {course.from_s, above_m},
                     {arrived_s, below_m},
                     {course.until_s, below_m},
                     {course.until_s + kBack_s, above_m}};
    return course;
}

HandCourse stroke_course(const Presented &presented, const Stimulus &stimulus,
                         const HandDeviation &hand) {
    HandCourse course;
    course.from_s = kServoStart_s + stimulus.rest_s;
    course.until_s = course.from_s + stimulus.presentation_s + kLater_s;
    course.points = stroke_points(stimulus.start_m, course.from_s, course.until_s - course.from_s,
                                  hand.share * presented.parameters.speed_m_per_s);
    course.points.insert(course.points.begin(), {0.0, stimulus.start_m});
    return course;
}

} // namespace

std::vector<simulated::HandPath::Point> stroke_points(const Vector3 &about_m, double from_s,
                                                      double duration_s, double speed_m_per_s) {
    constexpr double kCorner_s = 0.01; // from one corner of the polyline to the next
    constexpr double kSoftly_s = 0.2;
    const double omega = speed_m_per_s / kStroke_m;
    std::vector<simulated::HandPath::Point> points;
    double since_s = 0.0;
    while (since_s < duration_s) {
        const double way_m =
            kStroke_m * -std::expm1(-since_s / kSoftly_s) * std::sin(omega * since_s);
        points.push_back({from_s + since_s, about_m + way_m * Vector3::UnitX()});
        since_s += kCorner_s;
    }
    return points;
}

HandCourse hand_course(const StudySetting &setting, const Presented &presented,
                       const Stimulus &stimulus, const HandDeviation &hand) {
    switch (stimulus.form) {
    case StimulusForm::blow:
        return blow_course(setting, presented, stimulus, hand);
    case StimulusForm::stroke:
        return stroke_course(presented, stimulus, hand);
    case StimulusForm::press:
    case StimulusForm::pulse:
        break;
    }
    return press_course(setting, presented, stimulus, hand);
}

} // namespace springdrive::study
