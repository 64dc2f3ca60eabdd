// Stability cases that several tests share, and random loops over the range of realistic motors,
// servos and hands.
#pragma once

#include "engine/lab/limits/stability_limits.h"
#include "engine/lab/loops/stability_case.h"
#include "tests/support/configurations.h"
#include "tests/support/devices.h"

#include <array>
#include <cmath>
#include <random>
#include <string_view>

namespace springdrive::testing {

/// One motor of the PHANTOM 1.0 with the tuning "firm".
inline loops::StabilityCase firm() {
    loops::StabilityCase which;
    which.device = phantom_1_0();
    return which;
}

inline const loops::StabilityParameter &named(std::string_view name) {
    return *loops::stability_parameter_named(name);
}

inline loops::StabilityCase with(loops::StabilityCase which,
                                 const loops::StabilityParameter &parameter, double value) {
    parameter.set(which, value);
    return which;
}

/// Random numbers within a range.
class Draw {
public:
    explicit Draw(std::mt19937_64 &random) : random_(random) {}

    double even(double low, double high) {
        return std::uniform_real_distribution<double>(low, high)(random_);
    }
    double by_ratio(double low, double high) { return low * std::pow(high / low, even(0.0, 1.0)); }
    int whole(int low, int high) { return std::uniform_int_distribution<int>(low, high)(random_); }

private:
    std::mt19937_64 &random_;
};

/// A motor in the range from watches to robots.
inline device::MotorParameters random_motor(std::mt19937_64 &random) {
    Draw draw(random);
    device::MotorParameters motor = phantom_1_0().motor[0];
    motor.resistance_Ohm = draw.by_ratio(0.5, 10.0);
    motor.inductance_H = draw.by_ratio(5e-5, 2e-3);
    motor.torque_constant_Nm_per_A = draw.by_ratio(0.01, 0.06);
    motor.rotor_inertia_kg_m2 = draw.by_ratio(3e-7, 1e-5);
    return motor;
}

/// Gains of a loop that may be stable.
inline control::Tuning random_tuning(const device::MotorParameters &motor,
                                     std::mt19937_64 &random) {
    Draw draw(random);
    control::Tuning tuning;
    tuning.dR_Ohm = motor.resistance_Ohm * draw.by_ratio(0.05, 1.0);
    tuning.K_P_V_per_rad = draw.by_ratio(0.1, 10.0);
    tuning.K_D_Vs_per_rad = draw.even(0.0, 0.02);
    tuning.lambda_rad_per_s = draw.by_ratio(200.0, 4000.0);
    tuning.eta = draw.whole(0, 2) == 0 ? draw.even(0.0, 0.9) : 0.0;
    return tuning;
}

/// One motor with a load inertia, with or without a hand.
inline loops::StabilityCase random_rotor_loop(std::mt19937_64 &random) {
    Draw draw(random);
    loops::StabilityCase which;
    which.device = phantom_1_0();
    which.device.motor.fill(random_motor(random));
    which.tuning = random_tuning(which.device.motor[0], random);
    which.period_s = draw.by_ratio(2e-4, 2e-3);
    which.delay_periods = draw.whole(0, 3);
    which.rotor = device::RotorLoad{draw.by_ratio(1e-6, 1e-4), draw.by_ratio(1e-7, 1e-3), 0.0};
    which.hands = {draw.whole(0, 2) == 0 ? loops::no_hand()
                                         : loops::hand_of_firmness(draw.even(0.0, 1.0))};
    return which;
}

/// The same with a delay of up to three periods, whole or fractional.
inline loops::StabilityCase random_delayed_loop(std::mt19937_64 &random) {
    loops::StabilityCase which = random_rotor_loop(random);
    which.delay_periods = Draw(random).even(0.0, 3.0);
    return which;
}

} // namespace springdrive::testing
