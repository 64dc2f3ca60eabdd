#include "engine/study/stimuli/force_steering.h"

#include <algorithm>
#include <cmath>

namespace springdrive::study {

ForceSteering::ForceSteering(const Vector3 &normal, const Vector3 &direction, Pace pace,
                             double max_work_J, double max_force_N, double period_s)
    : normal_(normal), slope_(direction / direction.dot(normal) - normal),
      is_prompt_(pace == Pace::prompt), max_work_J_(max_work_J), max_force_N_(max_force_N),
      gap_share_(-std::expm1(-period_s / kTime_s)) {}

void ForceSteering::count(const Vector3 &tip_m, const Vector3 &force_N) noexcept {
    const Vector3 along_N = force_N - force_N.dot(normal_) * normal_;
    if (has_last_) {
        work_J_ += 0.5 * (along_N + last_force_N_).dot(tip_m - last_tip_m_);
        has_given_up_ = has_given_up_ || work_J_ > max_work_J_;
    }
    has_last_ = true;
    last_tip_m_ = tip_m;
    last_force_N_ = along_N;
}

Vector3 ForceSteering::update(const Vector3 &tip_m, const Vector3 &force_N, double share) noexcept {
    count(tip_m, force_N);
    const double pressed_N = std::max(0.0, force_N.dot(normal_));
    const Vector3 wanted_N =
        has_given_up_ ? Vector3(Vector3::Zero()) : Vector3(share * pressed_N * slope_);
    integral_N_ += gap_share_ * (wanted_N - last_force_N_);
    const Vector3 at_once_N = is_prompt_ ? wanted_N : Vector3(Vector3::Zero());
    const Vector3 added_N = at_once_N + integral_N_;
    const double size_N = added_N.norm();
    if (size_N > max_force_N_) {
        integral_N_ = added_N * (max_force_N_ / size_N) - at_once_N;
        return added_N * (max_force_N_ / size_N);
    }
    return added_N;
}

} // namespace springdrive::study
