// The whole control law of one tick as a function over values: (30), then (18) or (23), then (10).
#pragma once

#include "base/vector.h"
#include "device/core/haptic_device.h"
#include "engine/contact/contact.h"
#include "engine/control/coupling.h"
#include "engine/control/motion_control.h"
#include "engine/control/tuning.h"
#include "engine/control/winding_observer.h"

#include <array>
#include <cstdint>
#include <limits>
#include <optional>

namespace springdrive::control {

/// What the sources of α need that do not follow from one configuration, in rad²/m².
struct AlphaSources {
    double global = 0.0; ///< the α of AlphaMode::global
    /// The α that was active in the tick before, if in contact; else ∞. With AlphaMode::at_touch α
    /// does not exceed it: a spring that only becomes softer returns no more than it stored.
    double before = std::numeric_limits<double>::infinity();
};

/// The command of the law with its intermediate results.
struct LawOutcome {
    double eta = 1.0;                     ///< active η, surface and tuning combined
    double alpha_rad2_per_m2 = 0.0;       ///< active α
    double alpha_bound_rad2_per_m2 = 0.0; ///< (29) at this configuration
    Vector3 x_Sd_m{Vector3::Zero()};
    std::optional<MotorSetPoint> inverse; ///< (18), where it has a solution
    MotorSetPoint transpose;              ///< (23), (24)
    MotorSetPoint used;                   ///< of the active map; no force where it has no solution
    Vector3 dR_Ohm{Vector3::Zero()};      ///< at which each motor is driven, as far as R is known
    Vector3 stiffness_share{Vector3::Ones()}; ///< of the tuning's K_q (20)
    Vector3 spring_A{Vector3::Zero()};        ///< i*: the current of its spring at rest
    Vector3 trim_V{Vector3::Zero()}; ///< part of e_W that makes up for what the current lacks
    device::DeviceCommand command;   ///< e_W (10) and R̂ (7)
};

/// Holds the device's constants; has no state from tick to tick.
class HapticLaw {
public:
    explicit HapticLaw(const device::DeviceDescription &device);

    /// θ, θ̇_f, x and J from the readings of the encoders and the velocity filter. RT-safe.
    [[nodiscard]] Configuration configuration(const Vector3 &theta_rad,
                                              const Vector3 &theta_rate_rad_per_s) const noexcept;

    /// @param motors  so that what is left of R is dR, and K_q (20) that of the file's k_T and the
    ///                tuning's dR: K_P and K_D are larger where k_T is smaller and where dR is held
    ///                up, see drive_gains.h
    /// @param lag_s   T (½ + d). RT-safe.
    [[nodiscard]] LawOutcome operator()(const Configuration &now, const contact::Contact &contact,
                                        const Tuning &tuning, const AlphaSources &alpha,
                                        const ObservedMotors &motors, double lag_s) const noexcept;

    /// The same with the motors of the device file, driven at the tuning's dR. RT-safe.
    [[nodiscard]] LawOutcome operator()(const Configuration &now, const contact::Contact &contact,
                                        const Tuning &tuning,
                                        const AlphaSources &alpha) const noexcept {
        return (*this)(now, contact, tuning, alpha, motors_of_file(motor_), 0.0);
    }

    /// The direction of the static tip force (19) of a motor set-point. RT-safe.
    [[nodiscard]] Vector3 force_direction(const Configuration &now,
                                          const MotorSetPoint &set_point) const noexcept;

    [[nodiscard]] const Vector3 &k_T() const { return k_T_; }

    /// K_DC (13) of each motor at the tuning's dR [N·m/rad]. RT-safe.
    [[nodiscard]] Vector3 static_stiffness_Nm_per_rad(const Tuning &tuning) const noexcept {
        return control::static_stiffness_Nm_per_rad(motor_, tuning);
    }

    /// θ of encoder counts [rad]. RT-safe.
    [[nodiscard]] Vector3 theta_rad(const std::array<std::int32_t, 3> &counts) const noexcept {
        return rad_per_count_ * Vector3(counts[0], counts[1], counts[2]);
    }

private:
    device::PhantomGeometry geometry_;
    std::array<device::MotorParameters, 3> motor_;
    Vector3 k_T_;
    Vector3 relative_stiffness_;
    double rad_per_count_;
};

} // namespace springdrive::control
