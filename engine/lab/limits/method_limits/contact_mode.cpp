#include "engine/lab/limits/method_limits/contact_mode.h"

#include "device/core/phantom/kinematics.h"

#include <cmath>

namespace springdrive::limits {

ContactMode::ContactMode(const loops::StabilityCase &which)
    : device(which.device), q_rad(which.q_rad) {
    loops::StabilityCase one = which;
    one.rotor.reset();
    one.freedom = loops::Freedom::one_motor;
    const loops::DrivenLoad load = loops::driven_load(one, {0, loops::no_hand()});
    inertia_kg_m2 = load.inertia_kg_m2(0, 0);
    damping_Nms_per_rad = load.damping_Nms_per_rad(0, 0);
    options.hand = {0.0, 0.0, 0.0, 0.0, 1.0};
    options.effects = simulated::PlantEffects::none();
    options.effects.viscous_friction = true;
    options.quantised_encoders = false;
    for (Eigen::Index j = 0; j < 3; ++j) {
        command.cancelled_resistance_Ohm[j] =
            device.motor[static_cast<std::size_t>(j)].resistance_Ohm - kNet_Ohm;
    }
}

std::complex<double> ContactMode::eigenvalue() const {
    const double middle = 0.5 * (winding_per_s() + rotor_per_s());
    const double product = winding_per_s() * rotor_per_s() + omega_squared();
    return -middle + std::sqrt(std::complex<double>(middle * middle - product));
}

rig::PlantState ContactMode::start() const {
    rig::PlantState y = rig::PlantState::Zero();
    y.head<3>() = q_rad;
    y[6] = kStart_A;
    return y;
}

double ContactMode::energy_J(const rig::PlantState &y) const {
    const double rate = device.geometry.transmission_ratio[0] * y[3];
    return 0.5 * (inertia_kg_m2 * rate * rate + motor().inductance_H * y[6] * y[6]);
}

rig::PlantEquations ContactMode::equations() const {
    rig::PlantEquations of(device, options);
    rig::PlantInputs inputs;
    inputs.command = command;
    inputs.target.position_m = device::tip_position_m(device.geometry, q_rad);
    of.set_inputs(inputs);
    return of;
}

} // namespace springdrive::limits
