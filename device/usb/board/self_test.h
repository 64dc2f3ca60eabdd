// Short voltage pulses on one winding after the other, the others open: measures each resistance
// and inductance, and whether motor, current sensor and encoder of a channel belong together and
// agree in sign.
//
//   voltage  +V ┌───────┐
//             ──┘       │       ┌── braking       resistance = 2 V/(i₊ − i₋)
//          −V           └───────┘
//   means           i₊       i₋
//
// The two means are taken at equal times before and after the change of sign, where the rotor has
// equal speeds, so that the back-EMF drops out. Each is taken in two parts, which give the line
// that the current would follow without inductance. What it lags behind that line after the change
// is L/R times the step Δi, so L = R Σ lag/Δi. Then all windings brake until the rotors rest.
//
// A host that falls silent, a fault, or a limit of this test ends it.
#pragma once

#include "device/usb/board/settings.h"

namespace springdrive::board {

class SelfTest {
public:
    /// Whether the order is within the limits, so that the test may start.
    [[nodiscard]] static bool accepts(const usb::SelfTestOrder &order,
                                      const BoardSettings &settings);

    /// @return whether it starts: the order is acceptable
    [[nodiscard]] bool start(const usb::SelfTestOrder &order, const BoardSettings &settings);

    /// One loop of a running test: which stages to drive, and with which voltage.
    struct Step {
        std::array<Stage, kChannels> stage{Stage::brake, Stage::brake, Stage::brake};
        Triple voltage_V{};
        bool has_ended = false;
    };
    [[nodiscard]] Step update(const Triple &current_A,
                              const std::array<std::int32_t, kChannels> &counts,
                              const BoardSettings &settings);

    void abort() {
        if (result_.state == usb::SelfTestState::running) {
            result_.state = usb::SelfTestState::aborted;
        }
    }

    [[nodiscard]] const usb::SelfTestResult &result() const { return result_; }

private:
    /// Sums of currents over loops, by their distance from the change of sign.
    struct Sums {
        Triple near_A{};
        Triple far_A{};
    };

    void begin_channel(const std::array<std::int32_t, kChannels> &counts);
    void add_currents(const Triple &current_A);
    void judge_channel(const std::array<std::int32_t, kChannels> &counts,
                       const BoardSettings &settings);
    [[nodiscard]] float mean_A(const Sums &sums, std::size_t channel) const;
    [[nodiscard]] float line_A(const Sums &sums, float distance) const;
    [[nodiscard]] float time_constant_s(const BoardSettings &settings) const;
    [[nodiscard]] std::int32_t moved(std::size_t encoder,
                                     const std::array<std::int32_t, kChannels> &counts) const;
    [[nodiscard]] bool is_beyond(const Triple &current_A,
                                 const std::array<std::int32_t, kChannels> &counts,
                                 const SelfTestLimits &limits) const;

    static constexpr std::uint32_t kRestShare_hz = 6; ///< braking after a channel lasts 1/6 s

    usb::SelfTestResult result_;
    float voltage_V_ = 0.0F;
    std::uint32_t pulse_loops_ = 0;
    std::uint32_t rest_loops_ = 0;
    std::size_t channel_ = 0;
    std::uint32_t loop_ = 0; ///< of this channel
    Sums positive_;
    Sums negative_;
    float after_change_A_ = 0.0F; ///< sum of the driven channel's, soon after the change
    std::array<std::int32_t, kChannels> counts_at_start_{};
};

} // namespace springdrive::board
