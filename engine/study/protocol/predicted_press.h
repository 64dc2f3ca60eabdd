// What a stimulus asks of the device, by statics: before anything is simulated.
#pragma once

#include "device/core/device_description.h"
#include "engine/study/protocol/presented.h"
#include "engine/study/protocol/study_setting.h"

#include <optional>

namespace springdrive::study {

struct PredictedPress {
    Vector3 q_rad{Vector3::Zero()}; ///< with the tip at the spot
    double stiffness_N_per_m = 0.0; ///< nᵀ K n with K of (21) or (27) and η of surface and tuning
    double depth_m = 0.0;           ///< below the surface, at the largest force
    Vector3 force_N{Vector3::Zero()}; ///< of the device, turned where the condition says so
    Vector3 held_N{Vector3::Zero()};  ///< the same between pulses; else the same
    double held_energy_J = 0.0; ///< in the spring: what a glide of its stiffness may give back
};

/// Of the hand at its firmest in this stimulus:
///
///   press    nᵀF = press_N
///   blow     nᵀF = v √(K m), the spring that takes all of ½ m v², with m the relaxed hand's mass
///            and the device's at the tip along n
///   pulse    press_N along n, and pulse_N along the turned direction
///
/// A press or blow is turned as a whole, so that only cos φ of it acts against the hand.
///
/// Nothing for a stroke, where the spot is out of reach, where J is singular or where nothing
/// resists.
[[nodiscard]] std::optional<PredictedPress>
predicted_press(const StudySetting &setting, const Presented &presented, StimulusForm form);

/// The motors' currents that hold a force at the tip: Jᵀ F/k_T [A].
[[nodiscard]] Vector3 currents_A(const device::DeviceDescription &device, const Vector3 &q_rad,
                                 const Vector3 &force_N);

/// Of a device without a hand, along a unit direction at the tip: 1/(nᵀ J M⁻¹ Jᵀ n) [kg].
[[nodiscard]] double tip_mass_kg(const device::DeviceDescription &device, const Vector3 &q_rad,
                                 const Vector3 &direction);

/// The energy that a pulse may give to a light hand: the lesser of what its impulse does to the
/// hand's mass and the device's, and what its force does to the hand's spring [J].
[[nodiscard]] double pulse_energy_J(const device::DeviceDescription &device,
                                    const PredictedPress &press, const Condition &condition);

} // namespace springdrive::study
