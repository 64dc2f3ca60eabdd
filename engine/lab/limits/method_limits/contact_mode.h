// The contact mode of the plant: a rotor with its load against the inductive stiffness K_L (4) of a
// winding with a constant set-point.
//
//   J θ̈ = k_T i − b θ̇        L di/dt = −dR i − k_T θ̇
#pragma once

#include "device/simulated/simulation_options.h"
#include "engine/lab/loops/stability_case.h"
#include "engine/lab/rig/plant_equations.h"

#include <complex>

namespace springdrive::limits {

/// Base joint and winding of a plant without hand or command.
struct ContactMode {
    static constexpr double kNet_Ohm = 0.1;  ///< small enough for the mode to oscillate
    static constexpr double kStart_A = 1e-3; ///< in the winding, at rest

    explicit ContactMode(const loops::StabilityCase &which);

    [[nodiscard]] const device::MotorParameters &motor() const { return device.motor[0]; }
    /// The decay rates of current and speed on their own.
    [[nodiscard]] double winding_per_s() const { return kNet_Ohm / motor().inductance_H; }
    [[nodiscard]] double rotor_per_s() const { return damping_Nms_per_rad / inertia_kg_m2; }
    /// K_L/J.
    [[nodiscard]] double omega_squared() const {
        return device::inductive_stiffness_Nm_per_rad(motor()) / inertia_kg_m2;
    }
    /// Eigenvalue of y' = A y with y = (θ̇, i), the one with the positive imaginary part.
    [[nodiscard]] std::complex<double> eigenvalue() const;

    [[nodiscard]] rig::PlantState start() const;
    [[nodiscard]] double energy_J(const rig::PlantState &y) const;
    [[nodiscard]] rig::PlantEquations equations() const;

    device::DeviceDescription device;
    Vector3 q_rad;
    simulated::SimulationOptions options;
    device::DeviceCommand command;
    double inertia_kg_m2 = 0.0; ///< of the base's motor with its load
    double damping_Nms_per_rad = 0.0;
};

} // namespace springdrive::limits
