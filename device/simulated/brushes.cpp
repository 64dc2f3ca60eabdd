#include "device/simulated/brushes.h"

#include <algorithm>
#include <cmath>

namespace springdrive::simulated {

namespace {

/// The root x of  impedance x + V_b tanh(x/i_b) = drive.
double balance_A(double brush_V, double brush_A, double impedance_Ohm, double drive_V) {
    // As tanh y ≤ min(y, 1), the root is beyond both of these; from there Newton's method rises to
    // it without passing it, because tanh is concave.
    const double size_V = std::abs(drive_V);
    double x =
        std::max(size_V / (impedance_Ohm + brush_V / brush_A), (size_V - brush_V) / impedance_Ohm);
    constexpr int kIterations = 4; // at 100 µs to 1e-6 of V_b
    for (int i = 0; i < kIterations; ++i) {
        const double share = std::tanh(x / brush_A);
        x += (size_V - impedance_Ohm * x - brush_V * share) /
             (impedance_Ohm + brush_V / brush_A * (1.0 - share * share));
    }
    return std::copysign(x, drive_V);
}

} // namespace

double brush_resistance_Ohm(double brush_V, double brush_A, double mean_A) noexcept {
    constexpr double kLinear = 1e-3; // tanh y = y to 3e-7
    return std::abs(mean_A) > kLinear * brush_A ? brush_V * std::tanh(mean_A / brush_A) / mean_A
                                                : brush_V / brush_A;
}

double mean_behind_brushes_A(double brush_V, double brush_A, const device::MotorParameters &motor,
                             const device::DriveState &now, double e_W_V,
                             double cancelled_resistance_Ohm, double step_s) noexcept {
    const double R = now.resistance_Ohm;
    const double stored_Ohm = 2.0 * motor.inductance_H / step_s;
    const auto behind_A = [&](double voltage_V, double net_Ohm) {
        return balance_A(brush_V, brush_A,
                         std::max(stored_Ohm + net_Ohm, device::kMinResidualShare * R),
                         stored_Ohm * now.current_A + voltage_V -
                             motor.torque_constant_Nm_per_A * now.rate_rad_per_s);
    };
    const double free_A = behind_A(e_W_V, R - cancelled_resistance_Ohm);
    const double e_A_V = cancelled_resistance_Ohm * free_A + e_W_V;
    const bool is_supplied = !now.limited || std::abs(e_A_V) <= motor.supply_V;
    return is_supplied ? free_A : behind_A(std::copysign(motor.supply_V, e_A_V), R);
}

} // namespace springdrive::simulated
