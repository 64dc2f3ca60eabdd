// What is simulated of a PHANTOM: its hand, its amplifiers, its enabled effects, and models of
// increasing detail made of them.
#pragma once

#include "base/vector.h"
#include "device/core/hand_parameters.h"
#include "device/core/motor/motor.h"
#include "device/core/motor/winding_heat.h"
#include "device/simulated/hand.h"

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

namespace springdrive::simulated {

/// The dynamic states of the simulated device.
enum class PlantDynamics : std::uint8_t {
    coupling,   ///< no mass and no inductance: hand, drives and dampers are always in balance
    rigid_body, ///< links and rotors have masses; currents follow e_W immediately
    electromechanical, ///< the windings have inductance, too
};

/// Effects that are simulated beyond rigid links, rotors, windings and encoders. Each can be
/// switched off individually.
struct PlantEffects {
    bool gravity = true;
    bool viscous_friction = true;
    bool coulomb_friction = true;
    bool joint_limits = true;
    bool amplifier_limits = true;   ///< supply voltage and peak current
    bool winding_heat = true;       ///< R(T); if off, windings stay as they are, at first at 25 °C
    bool commutation_ripple = true; ///< R(θ)
    // With both, the compliance is split by the file's cable_share, or as `device_seed` draws it.
    bool structural_compliance = false; ///< between linkage and tip; needs a mass at the tip
    bool cable_compliance = false;      ///< between rotors and linkage; needs masses
    bool magnet_heat = true;            ///< k_T(T) of the housing, as warm as with winding_heat
    // With a `device_seed` only:
    bool motor_tolerances = true; ///< of R, its ripple, k_T and the winding's heat path
    bool commutator_phase = true; ///< of the ripples, against the encoder's zero
    bool current_sensing = true;  ///< resolution, noise, offset and gain of the current sensors
    bool brush_voltage = true;    ///< of brushes and bridge, with the sign of the current
    bool torque_ripple = true;    ///< k_T(θ)

    [[nodiscard]] static constexpr PlantEffects none() {
        return {false, false, false, false, false, false, false, false,
                false, false, false, false, false, false, false};
    }
};

/// An effect and its name.
struct PlantEffect {
    std::string_view name;
    bool PlantEffects::*on = nullptr;
};

/// The list of all effects, read by command line and tests.
inline constexpr std::array<PlantEffect, 15> kPlantEffects{{
    {"gravity", &PlantEffects::gravity},
    {"viscous_friction", &PlantEffects::viscous_friction},
    {"coulomb_friction", &PlantEffects::coulomb_friction},
    {"joint_limits", &PlantEffects::joint_limits},
    {"amplifier_limits", &PlantEffects::amplifier_limits},
    {"winding_heat", &PlantEffects::winding_heat},
    {"commutation_ripple", &PlantEffects::commutation_ripple},
    {"structural_compliance", &PlantEffects::structural_compliance},
    {"cable_compliance", &PlantEffects::cable_compliance},
    {"magnet_heat", &PlantEffects::magnet_heat},
    {"motor_tolerances", &PlantEffects::motor_tolerances},
    {"commutator_phase", &PlantEffects::commutator_phase},
    {"current_sensing", &PlantEffects::current_sensing},
    {"brush_voltage", &PlantEffects::brush_voltage},
    {"torque_ripple", &PlantEffects::torque_ripple},
}};

struct SimulationOptions {
    static constexpr int kMaxDelay = 8;

    double servo_period_s = 1e-3;   ///< T; each `read` advances the plant by T
    double delay_periods = 0.0;     ///< d, whole or fractional, at most kMaxDelay
    bool quantised_encoders = true; ///< false: 10,000 times as many counts
    /// Upper limit of sub-steps. In hard contact at 1 kHz the default agrees with fifty times
    /// shorter steps to 2 µm at the tip and to 0.1 % of their largest current.
    double longest_step_s = 100e-6;
    device::HandParameters hand;
    std::optional<HandPath>
        path; ///< the hand follows it to its end; then, and without one, `set_hand_target`
    PlantDynamics dynamics = PlantDynamics::electromechanical;
    PlantEffects effects;
    bool planar = false; ///< the base joint is at rest, so that only two are simulated
    device::AmplifierKind amplifier = device::AmplifierKind::spring_drive;
    Vector3 resistance_share{Vector3::Ones()}; ///< each motor's true R relative to its data sheet's
    double ambient_C = device::kReferenceTemperature_C;
    /// V_b of all motors' brushes and bridges, V_b tanh(i/i_b), with a constant i_b: in place of
    /// the drawn ones, whatever the effects.
    std::optional<double> brush_voltage_V;
    double brush_current_A = 0.01;
    /// Which device of its kind it is: its motors' and sensors' deviations are drawn from this. 0
    /// is the device that its file describes, with ideal sensors.
    std::uint64_t device_seed = 0;
};

/// A model and its name.
struct PlantModel {
    std::string_view name;
    PlantDynamics dynamics = PlantDynamics::electromechanical;
    PlantEffects effects;
};

/// Models of increasing detail: from the coupling alone, the cheapest, to everything that is known
/// about a device.
inline constexpr std::array<PlantModel, 5> kPlantModels{{
    {"coupling", PlantDynamics::coupling, PlantEffects::none()},
    {"rigid_tip", PlantDynamics::rigid_body, {true, true, false, true, true, false, false, false}},
    {"electromechanical",
     PlantDynamics::electromechanical,
     {true, true, false, true, true, true, true, false}},
    {"rigid_links",
     PlantDynamics::electromechanical,
     {true, true, true, true, true, true, true, false}},
    {"full", PlantDynamics::electromechanical, {true, true, true, true, true, true, true, true}},
}};

/// Controls of a simulated device beyond the interface of every device: the hand that holds it, and
/// what is simulated.
class SimulatedWorld : public HandControl {
public:
    /// From the next period on, uses the dynamics, effects, planar, longest_step_s, delay_periods
    /// and hand of `options`; all else is unchanged, and what the device reports of itself, too.
    /// Motors and linkage continue from their present state, so no encoder jumps. A moving base
    /// joint is not locked: planar takes effect only if it was on before. Stops that the linkage is
    /// beyond become active once it is back between them. One thread at a time, any thread.
    /// @throw InputError for options that are out of range or incompatible
    virtual void simulate_as(const SimulationOptions &options) = 0;
};

} // namespace springdrive::simulated
