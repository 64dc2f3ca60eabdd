// The board's end of the protocol: frames and control requests in, reports out.
//
// Numbering. After power-up and after a disconnection a board accepts no command until one that
// begins the numbering, which brakes: neither a board that restarted nor a host that did resumes
// driving unnoticed. From then on, a command is accepted if its number is after that of the last
// accepted one. Only an accepted command feeds the watchdog.
#pragma once

#include "device/usb/board/exchange.h"
#include "device/usb/board/settings.h"
#include "device/usb/board/values.h"

namespace springdrive::board {

/// The board's own limits of commands. A command is obeyed or rejected as a whole, never altered: a
/// clipped matrix would turn forces, and a host that asks for too much has an error that it should
/// learn of. After a rejection the last command holds until the watchdog brakes.
///
/// R̂ stays below a bound in every direction, so that no combination of currents sees less
/// resistance than R minus that bound, which is R at 25 °C within its tolerance, and what it
/// certainly rose.
///
/// @param largest_cancelled_Ohm  at the windings' present temperatures
/// @return ok, coupled or beyond_limits
[[nodiscard]] constexpr usb::FrameStatus check_limits(const usb::Command &command,
                                                      const BoardSettings &settings,
                                                      const Triple &largest_cancelled_Ohm) {
    using usb::FrameStatus;
    if (command.mode != usb::Mode::drive) {
        return FrameStatus::ok;
    }
    const SymmetricMatrix &R_hat = command.cancelled_resistance_Ohm;
    const SymmetricMatrix &L_hat = command.cancelled_inductance_H;
    if (!settings.couples_channels && !(R_hat.is_diagonal() && L_hat.is_diagonal())) {
        return FrameStatus::coupled;
    }
    const auto uniform = [](float bound) { return Triple{bound, bound, bound}; };
    const auto negated = [](const SymmetricMatrix &M) { return scaled_sum(-1.0F, M, {}); };
    bool is_within = true;
    for (const float e_W_V : command.e_W_V) {
        is_within = is_within && magnitude(e_W_V) <= settings.largest_voltage_V;
    }
    is_within = is_within && is_positive_definite(below(largest_cancelled_Ohm, R_hat)) &&
                is_positive_definite(below(uniform(settings.largest_added_Ohm), negated(R_hat))) &&
                is_positive_definite(below(uniform(settings.largest_cancelled_H), L_hat)) &&
                is_positive_definite(below(uniform(settings.largest_added_H), negated(L_hat)));
    return is_within ? FrameStatus::ok : FrameStatus::beyond_limits;
}

/// Largest payload of a control request.
inline constexpr std::size_t kMaxPayload = usb::kCapabilitiesSize;

class Link {
public:
    Link(const BoardSettings &settings, const usb::Identity &identity);

    /// A frame from the OUT endpoint.
    /// @return what became of it
    usb::FrameStatus receive(const std::uint8_t *data, std::size_t size,
                             std::uint32_t arrived_at_us, const LoopStatus &loop);

    /// The newest report for the IN endpoint, once.
    [[nodiscard]] bool take_report(usb::Frame &frame, const LoopStatus &loop);

    /// A control request with data from the host.
    /// @return false: to be stalled
    [[nodiscard]] bool control_out(std::uint8_t request, const std::uint8_t *data, std::size_t size,
                                   const LoopStatus &loop);

    /// A control request for data.
    /// @param payload  kMaxPayload bytes
    /// @return the size of the payload; 0: to be stalled
    [[nodiscard]] std::size_t control_in(std::uint8_t request, std::uint16_t value,
                                         std::uint8_t *payload, const LoopStatus &loop) const;

    /// The bus was reset or suspended, or the cable pulled.
    void disconnect();
    void set_speed(bool is_high_speed) { is_high_speed_ = is_high_speed; }

    /// A stored calibration block, at the start.
    void load(const usb::CalibrationBlock &block);
    /// The next block that the host wrote, once. Until `end_store`, no motor is driven.
    [[nodiscard]] bool take_block_to_store(usb::CalibrationBlock &block);
    void end_store(std::uint16_t index, bool is_stored);

    /// The orders are about to be passed on.
    void count_change() { ++orders_.changes; }
    [[nodiscard]] const Orders &orders() const { return orders_; }

private:
    usb::FrameStatus reject(usb::FrameStatus status);
    [[nodiscard]] usb::FrameStatus check_number(const usb::Command &command) const;
    [[nodiscard]] bool write_block(const usb::CalibrationBlock &block, bool must_store);
    [[nodiscard]] bool may_store() const;
    [[nodiscard]] std::uint32_t shortest_report_period_us() const;
    [[nodiscard]] usb::Capabilities capabilities(const LoopStatus &loop) const;
    [[nodiscard]] usb::Counters counters(const LoopStatus &loop) const;

    BoardSettings settings_;
    usb::Identity identity_;
    bool is_high_speed_ = true;
    Orders orders_;
    bool has_number_ = false;
    usb::FrameStatus last_rejection_ = usb::FrameStatus::ok;
    std::uint16_t rejected_frames_ = 0;
    usb::Counters counters_;
    std::uint32_t reports_taken_ = 0;
    std::array<usb::CalibrationBlock, kCalibrationBlocks> block_{};
    std::array<bool, kCalibrationBlocks> must_store_{};
    std::array<bool, kCalibrationBlocks> is_unstored_{};
};

} // namespace springdrive::board
