// What was learned of one device beyond the file of its kind, and by whom.
#pragma once

#include <array>
#include <cstdint>
#include <string>

namespace springdrive::device {

/// Of one motor. Deviations are standard deviations. Resistances are as its amplifier sees them,
/// R/(1 + g) with the gain error g of its current sensor, which nothing here tells.
struct MotorCalibration {
    double resistance_Ohm = 0.0;           ///< at 25 °C, averaged over the commutator's angles
    double resistance_deviation_Ohm = 0.0; ///< without that of the air's temperature
    // R(θ) less its mean is the sum of cos(n s θ) and sin(n s θ) with these, n = 1 and 2.
    double ripple_cos_Ohm = 0.0;
    double ripple_sin_Ohm = 0.0;
    double ripple_deviation_Ohm = 0.0; ///< of each of the two
    double ripple_cos_2_Ohm = 0.0;
    double ripple_sin_2_Ohm = 0.0;
    double ripple_2_deviation_Ohm = 0.0;
    double torque_constant_Nm_per_A = 0.0; ///< by back-EMF
    double torque_constant_deviation_Nm_per_A = 0.0;
    double offset_A = 0.0; ///< of the current's sensor
    double offset_deviation_A = 0.0;
};

/// By which an angle may be off that a person found by eye, the zero pose of a joint [rad]: 2°.
inline constexpr double kZeroByEye_rad = 0.0349;

struct Calibration {
    std::string serial;         ///< of the device, as in DeviceIdentity, like the next two
    std::string kind;           ///< "simulated", "USB"
    std::string firmware;       ///< empty if it was read from a board
    std::int64_t made_at_s = 0; ///< UTC, since 1970
    double air_C = 25.0;        ///< of the air then,
    double air_error_K = 10.0;  ///< to within so much, either way
    std::array<MotorCalibration, 3> motor;

    /// Whether counts and sensors' offsets are those of the calibration whenever the device is
    /// opened: they are those of a simulated device. A board counts from 0 after each power-up, so
    /// that its zero is found by eye again, and measures its sensors' offsets anew.
    [[nodiscard]] bool has_lasting_zero() const { return kind == "simulated"; }
};

/// "2026-11-25T05:10:22Z".
[[nodiscard]] std::string text_of_utc(std::int64_t seconds_since_1970);

} // namespace springdrive::device
