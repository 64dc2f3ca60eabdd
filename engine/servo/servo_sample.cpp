#include "engine/servo/servo_sample.h"

#include "engine/control/rendered_force.h"

#include <limits>

namespace springdrive::servo {

namespace {

/// Below this the direction of a rendered force is meaningless: single encoder counts in the
/// velocity signal cause forces of this size.
constexpr double kMinForceWithDirection_N = 0.1;

/// Below this a set-point coincides with the tip up to round-off, for instance at η = 1.
constexpr double kMinSetPointGap_m = 1e-6;

constexpr double kNoDirection = std::numeric_limits<double>::quiet_NaN();

} // namespace

void note_law(const control::HapticLaw &law, const control::Configuration &now,
              const control::LawOutcome &found, ServoSample &sample) noexcept {
    const contact::Contact &contact = sample.contact;
    sample.eta = found.eta;
    sample.alpha_rad2_per_m2 = found.alpha_rad2_per_m2;
    sample.alpha_bound_rad2_per_m2 = found.alpha_bound_rad2_per_m2;
    sample.inverse_possible = found.inverse.has_value();
    sample.x_Sd_m = found.x_Sd_m;
    sample.theta_Sd_rad = found.used.theta_Sd_rad;
    sample.dR_Ohm = found.dR_Ohm;
    sample.stiffness_share = found.stiffness_share;

    const bool pushes = contact.touching && (found.x_Sd_m - now.tip_m).norm() > kMinSetPointGap_m;
    const auto static_error = [&](const control::MotorSetPoint &set_point) {
        return control::direction_error_rad(law.force_direction(now, set_point), contact.normal);
    };
    sample.inverse_error_rad =
        pushes && found.inverse ? static_error(*found.inverse) : kNoDirection;
    sample.transpose_error_rad = pushes ? static_error(found.transpose) : kNoDirection;
}

void note_rendered_error(ServoSample &sample) noexcept {
    const contact::Contact &contact = sample.contact;
    sample.rendered_error_rad =
        contact.touching && sample.tip_force_N.norm() > kMinForceWithDirection_N
            ? control::direction_error_rad(sample.tip_force_N, contact.normal)
            : kNoDirection;
}

} // namespace springdrive::servo
