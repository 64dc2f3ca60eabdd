// What a protocol's names stand for (its device, and the scene and spot of each condition), and
// what it presents there, condition by condition and level by level.
#pragma once

#include "device/core/device_description.h"
#include "engine/contact/proxy/haptic_surface.h"
#include "engine/study/protocol/protocol.h"
#include "engine/study/stimuli/stimulus.h"

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace springdrive::study {

/// Where names lead.
struct ProtocolFolders {
    std::filesystem::path own; ///< of the protocol's file: files that it names are relative to it
    std::filesystem::path assets; ///< of what is included
};

// A file must lie in the protocol's folder: these @throw InputError for one that does not.

/// assets/devices/NAME.toml of an included device, or the file.
[[nodiscard]] std::filesystem::path device_file_of(const Protocol &protocol,
                                                   const ProtocolFolders &folders);

/// assets/scenes/NAME.gltf of an included scene, or the file. @pre the condition has a scene
[[nodiscard]] std::filesystem::path scene_file_of(const Condition &condition,
                                                  const ProtocolFolders &folders);

/// One of a study's conditions, ready to be looked at.
struct PlacedCondition {
    std::shared_ptr<const contact::HapticSurface> surface; ///< null in free space
    scene::TouchSpot spot;    ///< in free space the place where the hand rests
    double surface_eta = 0.0; ///< of the material at the spot; 1 in free space
    /// Why it cannot be used, with what to do; then the rest is as far as it came.
    std::string problem;
};

struct StudySetting {
    device::DeviceDescription device;
    std::vector<PlacedCondition> conditions; ///< in the protocol's order
    double global_alpha_rad2_per_m2 = 0.0;   ///< of control::AlphaMode::global
};

/// Loads the device and all scenes; each scene once.
/// @throw InputError if the device cannot be read.
[[nodiscard]] StudySetting study_setting(const Protocol &protocol, const ProtocolFolders &folders);

/// Height above the spot, along its normal, at which a trial begins.
inline constexpr double kApproach_m = 0.02;

/// A stroke goes so far to either side of the spot, along the device's x axis.
inline constexpr double kStroke_m = 0.03;

// Everything that a protocol can present, condition by condition and level by level.

/// A comparison at a level, or a standard.
struct Presented {
    std::size_t condition = 0;   ///< index into `Protocol::conditions`
    std::optional<double> level; ///< nothing: the standard
    Condition parameters;
    control::Tuning free_space; ///< in force before and after; its η is that of contact
    int target = 0;             ///< of a forced choice by place, from 0
};

/// Of every condition in use, the standard and the comparison at all `presentable_levels`.
/// Conditions that are in no block and no standard are left out; so are those that cannot be in
/// free space as the protocol wants it.
[[nodiscard]] std::vector<Presented> all_presented(const Protocol &protocol);

/// Of each condition only the standard and the comparisons at the lowest and highest level.
[[nodiscard]] std::vector<Presented> extremes(const std::vector<Presented> &all);

/// "condition \"soft\" at level 0.9 (eta 0.9)".
[[nodiscard]] std::string name_of(const Protocol &protocol, const Presented &presented);

/// Whether a condition is in a block or the standard.
[[nodiscard]] bool is_used(const Protocol &protocol, std::size_t condition);

// What a stimulus asks of the device, by statics: before anything is simulated.

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

// From a condition of a protocol to what the servo is to present, and what is to come of it.

/// A force is steered where it is turned, and in a cup under the transpose map even if it is not:
/// there it would lean to wherever the hand leans. Pulses are not: they come on top of a force that
/// is along the normal.
[[nodiscard]] bool is_steered(const Protocol &protocol, const Condition &condition);

/// The longest that a hand stays in contact after a presentation, of all that the protocol
/// presents.
[[nodiscard]] double longest_glide_back_s(const Protocol &protocol);

/// After all of a protocol's stimuli the hand stays in contact equally long: the time is no hint.
[[nodiscard]] Stimulus stimulus_of(const Protocol &protocol, const StudySetting &setting,
                                   const Presented &presented);

/// By statics, see `predicted_press`. Of a direction nothing in a cup under the inverse map, where
/// it is the hand's; and of a blow nothing unless it is turned.
[[nodiscard]] StimulusMeasures intended_measures(const Protocol &protocol,
                                                 const StudySetting &setting,
                                                 const Presented &presented);

} // namespace springdrive::study
