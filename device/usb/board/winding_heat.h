// I²t of one winding: lower and upper bound of its temperature from the measured current, by the
// motor's two-body network. A rise of the upper bound to the winding's limit trips the board; the
// lower bound permits a hot winding, whose R has risen, a larger R̂.
//
//   C_w dT_w/dt = R i² − (T_w − T_h)/R_wh      C_h dT_h/dt = (T_w − T_h)/R_wh − (T_h − T_air)/R_ha
//
// What was before power-up, or in a pause of the loop, nobody saw: the lower bound then starts from
// the coldest air. The upper bound starts from the hottest state that its own limit permits, a
// winding that has been at the limit for hours, and does not fall in a pause.
//
// Explicit steps of kPeriod_s, 1/240 of the faster time constant: shorter ones would be lost in the
// rounding of `float`.
#pragma once

#include "device/usb/board/settings.h"

namespace springdrive::board {

class WindingHeat {
public:
    static constexpr std::uint32_t kPeriod_us = 50'000;
    static constexpr float kPeriod_s = 1e-6F * static_cast<float>(kPeriod_us);

    WindingHeat() = default;
    WindingHeat(const WindingSettings &winding, float gain_tolerance, bool starts_cold)
        : winding_(winding), gain_tolerance_(gain_tolerance) {
        if (!starts_cold) {
            const float outer = winding.housing_ambient_K_per_W;
            upper_.winding_K = winding.largest_winding_C - winding.warmest_air_C;
            upper_.housing_K = upper_.winding_K * outer / (outer + winding.winding_housing_K_per_W);
        }
    }

    /// Advances by kPeriod_s with the mean of the squared current in it.
    void update(float mean_square_A2) {
        const float spread = winding_.resistance_tolerance + winding_.commutation_ripple;
        const float gain = 2.0F * gain_tolerance_; // of a square
        const float heat_W = winding_.resistance_Ohm * mean_square_A2;
        warm(upper_, heat_W * (1.0F + spread) * rise_at(upper_C()) * (1.0F + gain));
        warm(lower_, heat_W * (1.0F - spread) * rise_at(lower_C()) * (1.0F - gain));
    }

    /// For a time that is not known, nobody saw the current.
    void forget_lower() { lower_ = {}; }

    [[nodiscard]] float upper_C() const { return winding_.warmest_air_C + upper_.winding_K; }
    [[nodiscard]] bool is_too_hot() const { return !(upper_C() <= winding_.largest_winding_C); }

    /// R by R at 25 °C, at least, of a winding that is no colder than that; at least 1.
    [[nodiscard]] float certain_rise() const {
        const float rise = rise_at(lower_C());
        return rise > 1.0F ? rise : 1.0F;
    }

private:
    struct Bodies {
        float winding_K = 0.0F; ///< above the air
        float housing_K = 0.0F;
    };

    [[nodiscard]] float lower_C() const { return winding_.coldest_air_C + lower_.winding_K; }
    /// Of R, by R at 25 °C.
    [[nodiscard]] float rise_at(float winding_C) const {
        return 1.0F + winding_.rise_per_K * (winding_C - 25.0F);
    }

    void warm(Bodies &bodies, float heat_W) const {
        const float flow_W =
            (bodies.winding_K - bodies.housing_K) / winding_.winding_housing_K_per_W;
        const float lost_W = bodies.housing_K / winding_.housing_ambient_K_per_W;
        bodies.winding_K += kPeriod_s / winding_.winding_time_s * winding_.winding_housing_K_per_W *
                            (heat_W - flow_W);
        bodies.housing_K += kPeriod_s / winding_.motor_time_s * winding_.housing_ambient_K_per_W *
                            (flow_W - lost_W);
    }

    WindingSettings winding_{};
    float gain_tolerance_ = 0.0F;
    Bodies lower_;
    Bodies upper_;
};

} // namespace springdrive::board
