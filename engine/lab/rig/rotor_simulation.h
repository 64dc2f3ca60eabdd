// One motor with its drive and servo in the time domain, with what a linear prediction neglects:
// encoder counts, supply limits, friction.
//
// Shares no matrix with the prediction. Sub-steps are short; the winding is exact for a steady
// rotor (device/core/motor/motor.h), the rotor implicit about the middle: second order.
#pragma once

#include "device/core/motor/motor.h"

#include <vector>

namespace springdrive::rig {

struct RotorSimulationOptions {
    device::MotorParameters motor;
    device::AmplifierKind drive = device::AmplifierKind::spring_drive;
    double current_bandwidth_rad_per_s = 0.0; ///< of a current drive
    double net_resistance_Ohm = 0.0;          ///< dR of a spring drive, as it is
    device::RotorLoad load;                   ///< all that moves, rotor included
    double period_s = 1e-3;
    double delay_periods = 0.0; ///< d, not negative
    double filter_pole = 0.0;   ///< a of the velocity filter
    double per_velocity = 0.0;  ///< command per θ̇_f: volts or amperes, see SampledLaw
    double per_position = 0.0;  ///< command per θ
    double quantum_rad = 0.0;   ///< of the encoder; 0: exact
    bool amplifier_limits = false;
    double coulomb_Nm = 0.0; ///< friction at the motor
    double start_rad = 1e-3; ///< initial angle, at rest
};

class RotorSimulation {
public:
    explicit RotorSimulation(const RotorSimulationOptions &options);

    /// One period of the servo: read, command, advance.
    void tick();

    [[nodiscard]] double theta_rad() const { return theta_rad_; }
    [[nodiscard]] double rate_rad_per_s() const { return rate_; }
    [[nodiscard]] double current_A() const { return current_A_; }

private:
    /// A part of the period with one command applied.
    struct Part {
        int steps = 0;
        double h_s = 0.0;
    };

    [[nodiscard]] double measured_rad() const;
    [[nodiscard]] double rate_after(const device::CurrentStep &drive, double h_s) const;
    void advance(double command, double h_s);
    void advance(double command, const Part &part);

    RotorSimulationOptions options_;
    Part first_;  ///< f T of d = n + f, behind the command before; no steps for whole d
    Part second_; ///< the rest
    double theta_rad_;
    double rate_ = 0.0;
    double current_A_ = 0.0;
    double before_rad_;
    double filtered_ = 0.0;
    std::vector<double> held_; ///< u[k−n−1] … u[k]
};

} // namespace springdrive::rig
