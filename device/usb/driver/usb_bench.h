// A board's test pulses, facts and stored calibration, by control requests.
#pragma once

#include "device/core/haptic_device.h"
#include "device/usb/driver/board_port.h"

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

namespace springdrive::usb {

/// What a driver knows of a board that is connected.
struct BoardStatus {
    std::string name; ///< in errors
    std::string speed;
    Identity identity;
    Capabilities capabilities;
    Report newest;
};

class UsbBench final : public device::Bench {
public:
    /// @param port    must outlive this
    /// @param status  asked whenever it is needed
    UsbBench(BoardPort &port, std::function<BoardStatus()> status)
        : port_(port), status_(std::move(status)) {}

    [[nodiscard]] double shortest_pulse_s() const override;
    void start_pulses(const device::PulseOrder &order) override;
    [[nodiscard]] device::PulseResult pulses() override;
    [[nodiscard]] std::vector<device::Fact> facts() override;
    [[nodiscard]] std::optional<device::Calibration> stored_calibration() override;
    void store(const device::Calibration &calibration) override;

private:
    [[nodiscard]] CalibrationBlock kept_block(const BoardStatus &board, std::uint16_t index);

    BoardPort &port_;
    std::function<BoardStatus()> status_;
};

} // namespace springdrive::usb
