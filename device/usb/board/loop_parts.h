// The parts of the amplifiers' loop that have a state of their own: the board's states as a table,
// encoders, offsets of the current sensors, heat of the windings, and whether they generate.
#pragma once

#include "device/core/motor/winding_balance.h"
#include "device/usb/board/amplifier.h"
#include "device/usb/board/values.h"
#include "device/usb/protocol.h"

#include <cstdint>

namespace springdrive::board {

// The board's states, as a table.
//
//   starting ──offsets──► braking ◄──────► driving
//      ▲                    │ ▲ ▲             │
//    reset             test │ │ └─ brake ── opened ◄─ open
//      │                    ▼ │
//   fault_open            testing         fault_braking ──reset──► braking
//
// A fault leads to fault_braking; of an amplifier or a sensor, or while the windings are open, to
// fault_open. Silence of the host leads from driving and testing to fault_braking.

using State = usb::BoardState;

enum class Event : std::uint8_t {
    offsets_ready,
    command_brake,
    command_drive,
    command_open,
    silence,       ///< no command within the watchdog period
    braking_fault, ///< any other than:
    opening_fault, ///< the bridge or a current sensor cannot be relied on
    reset,         ///< requested, and no cause of a fault persists
    test_started,
    test_ended,
};
inline constexpr std::size_t kEvents = 10;

/// Driving needs a command to drive in `braking`. A host that falls silent in `opened` suspected an
/// amplifier, so it stays open.
[[nodiscard]] constexpr State next_state(State state, Event event) {
    using enum usb::BoardState;
    constexpr std::array<std::array<State, kEvents>, usb::kBoardStates> kNext{{
        // offsets_ready, command_brake, _drive, _open, silence,
        // braking_fault, opening_fault, reset, test_started, test_ended
        {braking, starting, starting, starting, starting, // starting
         fault_open, fault_open, starting, starting, starting},
        {braking, braking, driving, opened, braking, // braking
         fault_braking, fault_open, braking, testing, braking},
        {driving, braking, driving, opened, fault_braking, // driving
         fault_braking, fault_open, braking, driving, driving},
        {opened, braking, opened, opened, opened, // opened
         fault_open, fault_open, opened, opened, opened},
        {testing, testing, braking, opened, fault_braking, // testing
         fault_braking, fault_open, braking, testing, braking},
        {fault_braking, fault_braking, fault_braking, fault_open, fault_braking, // fault_braking
         fault_braking, fault_open, braking, fault_braking, fault_braking},
        {fault_open, fault_open, fault_open, fault_open, fault_open, // fault_open
         fault_open, fault_open, starting, fault_open, fault_open},
    }};
    return kNext[static_cast<std::size_t>(state)][static_cast<std::size_t>(event)];
}

/// Faults that open the windings.
inline constexpr std::uint16_t kOpeningFaults = usb::Faults::kAmplifier | usb::Faults::kSensor;

/// Extends the 16-bit counter of an encoder to 32 bits.
class Encoder {
public:
    /// Counts since the last update; the first one counts from zero.
    /// @return false for a step larger than `largest_step`, either way: no motor turns so fast. The
    ///         counts follow it, but may be wrong by multiples of 2^16.
    [[nodiscard]] bool update(std::uint16_t counter, std::int32_t largest_step) {
        const auto step = static_cast<std::int16_t>(
            static_cast<std::uint16_t>(has_counter_ ? counter - counter_ : 0));
        counter_ = counter;
        has_counter_ = true;
        raw_counts_ += static_cast<std::uint32_t>(static_cast<std::int32_t>(step));
        return step >= -largest_step && step <= largest_step;
    }

    /// Counts as the host sees them, modulo 2^32.
    /// @param sign  1 or −1: direction of the encoder against its motor
    [[nodiscard]] std::int32_t counts(std::int8_t sign) const {
        return static_cast<std::int32_t>((sign < 0 ? 0U - raw_counts_ : raw_counts_) + offset_);
    }

    /// Declares the counts of the present angle.
    void declare(std::int32_t counts, std::int8_t sign) {
        offset_ = 0;
        offset_ =
            static_cast<std::uint32_t>(counts) - static_cast<std::uint32_t>(this->counts(sign));
    }

private:
    std::uint32_t raw_counts_ = 0; ///< modulo 2^32, as signed overflow is undefined
    std::uint32_t offset_ = 0;
    std::uint16_t counter_ = 0;
    bool has_counter_ = false;
};

/// Offsets of the current sensors, measured while the windings are open and carry no current.
class CurrentOffsets {
public:
    /// After opening, currents decay through the power stages' diodes; then the mean is taken.
    static constexpr int kSettlingLoops = 128;
    static constexpr int kMeasuredLoops = 1024; ///< noise of the mean: 1/32 of a sample's

    enum class Progress : std::uint8_t { measuring, ready, failed };

    void restart() { *this = CurrentOffsets(); }

    [[nodiscard]] Progress update(const Triple &current_A, float largest_A) {
        if (++loops_ <= kSettlingLoops) {
            return Progress::measuring;
        }
        for (std::size_t i = 0; i < kChannels; ++i) {
            sum_A_[i] += current_A[i];
        }
        if (loops_ < kSettlingLoops + kMeasuredLoops) {
            return Progress::measuring;
        }
        bool is_plausible = true;
        for (std::size_t i = 0; i < kChannels; ++i) {
            offset_A_[i] = sum_A_[i] * (1.0F / static_cast<float>(kMeasuredLoops));
            is_plausible = is_plausible && magnitude(offset_A_[i]) <= largest_A; // not for NaN
        }
        return is_plausible ? Progress::ready : Progress::failed;
    }

    [[nodiscard]] const Triple &offset_A() const { return offset_A_; }

private:
    int loops_ = 0;
    Triple sum_A_{};
    Triple offset_A_{};
};

/// I²t of one winding: lower and upper bound of its temperature from the measured current, by the
/// motor's two-body network. A rise of the upper bound to the winding's limit trips the board; the
/// lower bound permits a hot winding, whose R has risen, a larger R̂.
///
///   C_w dT_w/dt = R i² − (T_w − T_h)/R_wh      C_h dT_h/dt = (T_w − T_h)/R_wh − (T_h − T_air)/R_ha
///
/// What was before power-up, or in a pause of the loop, nobody saw: the lower bound then starts
/// from the coldest air. The upper bound starts from the hottest state that its own limit permits,
/// a winding that has been at the limit for hours, and does not fall in a pause.
///
/// Explicit steps of kPeriod_s, 1/240 of the faster time constant: shorter ones would be lost in
/// the rounding of `float`.
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

/// Whether a winding generates, by what acted on it and what came of it since the last check: see
/// device/core/motor/winding_balance.h. L̂ adds L̂ di/dt to e_W.
class Balances {
public:
    Balances() = default;
    explicit Balances(const BoardSettings &settings)
        : loop_period_s_(settings.loop_period_s()),
          lag_s_(settings.actuation_lag_periods * settings.loop_period_s()) {
        const float older = settings.actuation_lag_periods - 0.5F;
        older_share_ = older < 0.0F ? 0.0F : older > 1.0F ? 1.0F : older;
        for (std::size_t i = 0; i < kChannels; ++i) {
            const WindingSettings &winding = settings.winding[i];
            const float hottest = 1.0F + winding.rise_per_K * (winding.largest_winding_C - 25.0F);
            count_rad_[i] = 6.2831853F / static_cast<float>(settings.counts_per_turn[i]);
            balance_[i] = device::WindingBalance(
                {winding.resistance_Ohm * (1.0F + winding.resistance_tolerance) * hottest,
                 winding.inductance_H, winding.torque_constant_Nm_per_A, count_rad_[i],
                 kNoiseDeviations * settings.current_noise_A + settings.current_resolution_A,
                 settings.offset_drift_A, loop_period_s_, winding.largest_brush_V, true});
        }
    }

    /// What the windings are driven with after the last sample: zero where they brake.
    void apply(const DriveSettings &drive) {
        older_e_W_V_ = newer_e_W_V_;
        newer_e_W_V_ = drive.e_W_V;
        is_known_ = is_known_ && drive.is_diagonal;
        for (std::size_t i = 0; i < kChannels; ++i) {
            e_W_sum_V_[i] += newer_e_W_V_[i] + older_share_ * (older_e_W_V_[i] - newer_e_W_V_[i]);
            R_hat_sum_Ohm_[i] += drive.cancelled_Ohm.diagonal[i];
            lead_H_[i] = drive.lead_H.diagonal[i] - lag_s_ * drive.cancelled_Ohm.diagonal[i];
        }
        ++loops_;
    }

    /// What acts is not known: windings are open, a limit acts, or a sample is missing.
    void spoil() { is_known_ = false; }

    /// @return whether one is found to generate, until `reset`
    [[nodiscard]] bool update(const Triple &current_A,
                              const std::array<std::int32_t, kChannels> &counts) {
        bool generates = false;
        const float share = loops_ > 0 ? 1.0F / static_cast<float>(loops_) : 0.0F;
        for (std::size_t i = 0; i < kChannels; ++i) {
            if (is_known_) {
                const float T = static_cast<float>(loops_) * loop_period_s_;
                const float lead_V = lead_H_[i] * (current_A[i] - current_A_[i]) / T;
                const float turned = static_cast<float>(usb::difference(
                    static_cast<std::uint32_t>(counts[i]), static_cast<std::uint32_t>(counts_[i])));
                balance_[i].update({T, e_W_sum_V_[i] * share + lead_V, newer_e_W_V_[i],
                                    newer_e_W_V_[i], R_hat_sum_Ohm_[i] * share, current_A_[i],
                                    current_A[i], count_rad_[i] * turned});
            } else {
                balance_[i].forget();
            }
            generates = generates || balance_[i].generates();
        }
        current_A_ = current_A;
        counts_ = counts;
        e_W_sum_V_ = {};
        R_hat_sum_Ohm_ = {};
        loops_ = 0;
        is_known_ = true;
        return generates;
    }

    void reset() {
        for (device::WindingBalance &balance : balance_) {
            balance.reset();
        }
    }

private:
    /// Of the difference of two currents: none is more.
    static constexpr float kNoiseDeviations = 8.5F;

    float loop_period_s_ = 0.0F;
    float lag_s_ = 0.0F;
    float older_share_ = 0.0F; ///< by which the older of two commands acts between two samples
    Triple count_rad_{};
    std::array<device::WindingBalance, kChannels> balance_;
    bool is_known_ = false;
    std::uint32_t loops_ = 0;
    Triple e_W_sum_V_{};
    Triple R_hat_sum_Ohm_{};
    Triple lead_H_{}; ///< L̂
    Triple newer_e_W_V_{};
    Triple older_e_W_V_{};
    Triple current_A_{}; ///< at the last check
    std::array<std::int32_t, kChannels> counts_{};
};

} // namespace springdrive::board
