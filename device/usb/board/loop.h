// The amplifiers' loop: everything that happens at the loop's rate, and may not wait for USB.
//
//   samples ──► counts, currents ──► faults ──► state ──► stages and voltages ──► bridge
//   orders ────────────────────────────────────►  │
//                                                 └──► report, when due
#pragma once

#include "device/usb/board/amplifier.h"
#include "device/usb/board/exchange.h"
#include "device/usb/board/loop_parts.h"
#include "device/usb/board/self_test.h"

namespace springdrive::board {

class Loop {
public:
    explicit Loop(const BoardSettings &settings);

    /// One loop. Every duty ratio is finite and within its limit, whatever the samples and orders.
    /// @param status  receives a report whenever one is due
    [[nodiscard]] BridgeOrder tick(const Samples &samples, const Orders &orders,
                                   Published<LoopStatus> &status);

    [[nodiscard]] State state() const { return state_; }
    [[nodiscard]] std::uint16_t faults() const { return faults_; }
    [[nodiscard]] std::uint32_t loops() const { return loops_; }

private:
    /// Supply and temperatures are checked every so many loops.
    static constexpr std::uint32_t kSlowLoops = 16;
    /// Samples in a row that must show a fault of current or supply, against spikes.
    static constexpr std::uint8_t kConfirmingLoops = 3;
    /// How long braked windings may carry more than the trip current: a shorted winding's decays
    /// in 0.1 ms, so a stage does not brake.
    static constexpr std::uint32_t kBrakingTime_us = 5000;
    static constexpr std::uint32_t kLatestLoop = 4; ///< loop periods; later is a fault
    /// Least share of the loop's own time that the timer of microseconds must pass in kSlowLoops.
    static constexpr float kSlowestTimer = 0.875F;

    void measure(const Samples &samples);
    void take_time(const Samples &samples);
    void take_orders(const Orders &orders);
    void renumber_counts();
    void take_command(const Orders &orders);
    void take_requests(const Orders &orders);
    void check_fast(const Samples &samples);
    void check_braking(const Samples &samples);
    void check_slow(const Samples &samples);
    void check_timer();
    void check_watchdog();
    void note_silence();
    void heat_windings();
    void forget_lower_heat();
    void handle(Event event);
    void raise(std::uint16_t fault);
    void request_reset();
    [[nodiscard]] BridgeOrder order(const Samples &samples);
    [[nodiscard]] BridgeOrder order_of_state(float supply_V);
    [[nodiscard]] BridgeOrder order_of_test(float supply_V);
    [[nodiscard]] BridgeOrder order_of_drive(float supply_V);
    [[nodiscard]] BridgeOrder checked(BridgeOrder order);
    [[nodiscard]] float usable_V(float supply_V) const;
    void note_application();
    void fill_in(usb::Report &report, const Samples &samples) const;
    void report_when_due(const Samples &samples, Published<LoopStatus> &status);

    BoardSettings settings_;
    float loop_period_us_;
    float lag_s_;

    // Measured.
    std::uint32_t time_us_ = 0;
    bool has_time_ = false;
    bool has_gap_ = false; ///< a loop is missing before this one
    std::array<Encoder, kChannels> encoder_;
    std::array<std::int32_t, kChannels> counts_{};
    Triple current_A_{}; ///< without offsets, with calibrated gains
    CurrentOffsets offsets_;
    std::array<WindingHeat, kChannels> heat_;
    Balances balances_;
    Triple square_sum_A2us_{};    ///< of currents, by the time that each stands for
    std::uint32_t passed_us_ = 0; ///< in the last loop
    std::uint32_t summed_us_ = 0;
    std::uint32_t checked_at_us_ = 0; ///< by check_timer

    // Ordered.
    Orders seen_;
    DriveSettings drive_;
    bool has_command_ = false;
    bool is_silent_ = true; ///< no command within the watchdog period
    bool is_applied_ = true;
    bool may_rephase_ = true;

    // State.
    State state_ = State::starting;
    std::uint16_t faults_ = 0;  ///< latched
    std::uint16_t present_ = 0; ///< causes that were there in the last check
    std::uint8_t over_current_loops_ = 0;
    std::uint8_t supply_loops_ = 0;
    std::uint32_t braked_since_us_ = 0;
    bool is_braking_hard_ = false;
    Amplifier amplifier_;
    SelfTest self_test_;
    std::uint8_t acting_ = 0; ///< limits, since the last report

    std::uint32_t report_due_us_ = 0;
    std::uint32_t reports_ = 0;
    std::uint8_t zeroings_ = 0;
    std::uint16_t applied_after_us_ = usb::kNotApplied;
    std::uint32_t silences_ = 0;
    std::uint32_t late_loops_ = 0;
    std::uint32_t loops_ = 0;
};

} // namespace springdrive::board
