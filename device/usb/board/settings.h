// Constants of a board and its motors, and the limits that it keeps whatever the host commands. The
// defaults are for a PHANTOM 1.0, with the values of assets/devices/phantom_1_0.toml; docs/board.md
// derives them.
#pragma once

#include "device/usb/board/values.h"

namespace springdrive::board {

/// A motor's winding: R, L and k_T, its two-body thermal network, and the bounds on R and air
/// temperature with which a board estimates it.
struct WindingSettings {
    float resistance_Ohm = 2.18F; ///< at 25 °C
    float inductance_H = 0.238e-3F;
    float torque_constant_Nm_per_A = 23.4e-3F;
    float largest_brush_V = 0.5F; ///< of brushes and bridge, with the sign of the current
    float resistance_tolerance = 0.05F;
    float commutation_ripple = 0.02F;
    float rise_per_K = 0.0039F; ///< of R, relative to R at 25 °C
    float winding_housing_K_per_W = 3.1F;
    float housing_ambient_K_per_W = 14.0F;
    float winding_time_s = 12.0F;
    float motor_time_s = 612.0F;
    float coldest_air_C = 15.0F;
    float warmest_air_C = 35.0F;
    float largest_winding_C = 100.0F;
};

struct SelfTestLimits {
    float largest_voltage_V = 2.0F; ///< of which brushes and bridge may take 0.5 V
    std::uint32_t longest_pulse_us = 20'000;
    float abort_current_A = 1.0F;
    std::int32_t abort_counts = 600; ///< 0.92 rad of a motor, 10 mm at the tip
    std::int32_t min_counts = 3;     ///< that count as motion
};

struct BoardSettings {
    std::uint32_t loop_rate_hz = 40'000;
    std::array<std::uint32_t, kChannels> counts_per_turn{4096, 4096, 4096};
    /// In one loop. At 513 rad/s, which 12 V turn the motor at without load, it counts 8.
    std::int32_t largest_count_step = 64;

    bool couples_channels = true;
    float nominal_supply_V = 15.0F; ///< where it is not measured
    bool measures_supply = true;
    float smallest_supply_V = 13.0F;
    float largest_supply_V = 18.0F;
    float largest_voltage_V = 12.0F; ///< of |e_W| and |e_A|
    float largest_duty_ratio = 0.95F;
    std::array<bool, usb::kTemperatures> measures_temperature{true, false, false, false};
    std::array<float, usb::kTemperatures> largest_temperature_C{85.0F, 80.0F, 80.0F, 80.0F};
    bool has_stop_switch = true;
    bool has_enable_line = true;

    float current_limit_A = 5.5F; ///< e_A drives no current beyond it, see amplifier.h
    float current_trip_A = 6.6F;
    float current_range_A = 8.0F; ///< of the sensors: a current near it is not known
    float current_resolution_A = 16.0F / 4096.0F;
    float largest_offset_A = 0.1F;  ///< of a sensor
    float gain_tolerance = 0.01F;   ///< of a sensor
    float current_noise_A = 0.003F; ///< of a sensor, r.m.s.
    float offset_drift_A = 0.005F;  ///< of a sensor, since it was measured

    /// Diagonal bound of R̂ for a winding at 25 °C, the file's R with its tolerance. The bound
    /// rises with the rise of R that the measured currents make certain.
    Triple largest_cancelled_Ohm{2.289F, 2.289F, 2.289F};
    float largest_added_Ohm = 4.4F;       ///< twice R; unstable from 14 Ω on
    float largest_cancelled_H = 0.12e-3F; ///< half of L
    float largest_added_H = 0.48e-3F;     ///< twice L; unstable from 3.6 L on
    float lead_bandwidth_rad_per_s = 40'000.0F;
    /// From sampling the currents to the middle of the PWM period in which the voltage computed
    /// from them acts, in loop periods: sampled in the middle of a period, applied in the next.
    float actuation_lag_periods = 1.0F;

    std::array<WindingSettings, kChannels> winding{};
    /// Whether the motors are no warmer than the air at power-up, as simulated ones are. Nothing
    /// that a real board knows by itself shows it.
    bool motors_start_cold = false;
    SelfTestLimits self_test{};
    std::uint32_t shortest_report_period_us = 125; ///< at high speed; at full speed at least 1000

    [[nodiscard]] constexpr float loop_period_s() const {
        return 1.0F / static_cast<float>(loop_rate_hz);
    }
};

inline constexpr std::uint16_t kCalibrationBlocks = 4;

} // namespace springdrive::board
