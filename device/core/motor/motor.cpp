#include "device/core/motor/motor.h"

#include <cmath>

namespace springdrive::device {

WindingStep winding_step(const MotorParameters &motor, double residual_resistance_Ohm,
                         double step_s) {
    const double x = -residual_resistance_Ohm * step_s / motor.inductance_H;
    // φ₂ loses half its digits to cancellation at |x| = 1e-8 and all at 1e-16; below 1e-2 its
    // series, truncated after x⁵, is exact to round-off (the next term is x⁶/40320 < 1e-16).
    const bool small = std::abs(x) < 1e-2;
    const double growth = std::expm1(x);
    const double phi1 = x == 0.0 ? 1.0 : growth / x;
    const double phi2 =
        small ? 1.0 / 2 +
                    x * (1.0 / 6 + x * (1.0 / 24 + x * (1.0 / 120 + x * (1.0 / 720 + x / 5040))))
              : (phi1 - 1.0) / x;
    const double h_over_L = step_s / motor.inductance_H;
    return {1.0 + growth, h_over_L * phi1, phi1, h_over_L * phi2};
}

} // namespace springdrive::device
