// The driver of a board behind a BoardPort, as a haptic device.
//
//   read()   packets ──► ReportStream ──► Measurement
//   write()  DeviceCommand ──► Command, its number and the next report's phase ──► packet
//
// Whatever the port does, `read` returns by its deadline, and says how old its data are.
#pragma once

#include "base/hand_over.h"
#include "device/core/haptic_device.h"
#include "device/usb/driver/board_port.h"
#include "device/usb/driver/report_stream.h"

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace springdrive::usb {

/// What a driver knows of a board that is connected.
struct BoardStatus {
    std::string name; ///< in errors
    std::string speed;
    Identity identity;
    Capabilities capabilities;
    Report newest;
};

/// A board's test pulses, facts and stored calibration, by control requests; in usb_bench.cpp.
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

/// What paces the servo.
enum class Pacing : std::uint8_t {
    clock,   ///< the host's clock: the board places its reports just before the ticks
    reports, ///< the board's reports, one a tick: `read` waits for the next one
};

class UsbDevice final : public device::HapticDevice {
public:
    /// Connects, checks the board against `description`, and begins the numbering.
    /// @param serial  empty: the only board
    /// @param period_s  T
    /// @param watchdog_periods  without a command, after which the board brakes by itself
    /// @throw InputError with one line: no board, or one that does not fit
    UsbDevice(std::unique_ptr<BoardPort> port, const device::DeviceDescription &description,
              std::string serial, double period_s, Pacing pacing, double watchdog_periods = 5.0);
    ~UsbDevice() override { close(); }
    UsbDevice(const UsbDevice &) = delete;
    UsbDevice &operator=(const UsbDevice &) = delete;

    /// With the board's own limits, where they are lower than the file's.
    [[nodiscard]] const device::DeviceDescription &description() const override {
        return description_;
    }
    [[nodiscard]] device::DeviceClock clock() const override { return device::DeviceClock::own; }
    [[nodiscard]] double delay_periods() const override;
    [[nodiscard]] device::Measurement read() noexcept override;
    void write(const device::DeviceCommand &command) noexcept override;

    [[nodiscard]] device::DeviceIdentity identity() const override { return identity_; }
    [[nodiscard]] std::optional<device::LinkStatus> link() const override;
    [[nodiscard]] device::Bench *bench() override { return &bench_; }
    [[nodiscard]] bool is_zeroed() const override { return is_zeroed_; }
    void set_period(double period_s) override;
    void zero(const Vector3 &theta_rad) override;
    void close() noexcept override;
    void reconnect() override;

    [[nodiscard]] const Capabilities &capabilities() const { return capabilities_; }

    /// Makes a calibration part of the description. While nobody else uses the device.
    void take_calibration(const device::Calibration &calibration);

private:
    /// The state that threads other than the servo's may see.
    struct Snapshot {
        StreamCounts counts;
        double delay_s = 0.0;
        double longest_delay_s = 0.0;
        double round_trip_s = 0.0;
        double longest_round_trip_s = 0.0;
        std::uint64_t unsent = 0;
        Report newest;
    };

    void connect();
    void check_identity();
    void check_capabilities();
    void request_report_rate(double period_s);
    void pass_over_old_reports();
    void begin_numbering();
    void settle_delay();
    [[nodiscard]] bool wait_for_report(double deadline_s) noexcept;
    [[nodiscard]] std::string name() const;
    [[nodiscard]] bool has_kept_counts() const;
    [[nodiscard]] bool has_fault(std::uint16_t fault) const noexcept;
    template <typename IsDone> bool exchange_until(device::BoardReset *reset, IsDone is_done);

    [[nodiscard]] double read_deadline_s(double now_s) const noexcept;
    [[nodiscard]] device::Measurement measurement(device::Arrival arrival) const noexcept;
    bool send(Command command, std::uint32_t measured_at_us, bool is_first) noexcept;
    [[nodiscard]] std::uint32_t measured_at_us(std::uint64_t number) const noexcept;
    void publish() noexcept;

    std::unique_ptr<BoardPort> port_;
    UsbBench bench_;
    device::DeviceDescription file_description_;
    device::DeviceDescription description_;
    std::string serial_;
    double period_s_;
    Pacing pacing_;
    double watchdog_periods_;
    device::DeviceIdentity identity_;
    Identity board_;
    Capabilities capabilities_;
    bool is_open_ = false;
    std::atomic<bool> is_zeroed_{false};
    std::uint8_t zeroings_ = 0; ///< of the board, when it was zeroed last

    // Of the servo's thread.
    struct MeasuredAt {
        std::uint64_t number = 0;
        std::uint32_t us = 0;
    };
    static constexpr std::size_t kRememberedReports = 64;
    ReportStream stream_;
    DelayMeter meter_;
    ReportPhase phase_;
    std::array<MeasuredAt, kRememberedReports> measured_at_{}; ///< by report
    double tick_s_ = 0.0;                                      ///< when `read` was called last
    std::uint32_t number_ = 0;                                 ///< of the last command
    bool has_new_command_ = false;                             ///< accepted since the report before
    std::uint64_t answered_ = 0; ///< the report from which the last command was computed
    std::uint16_t watchdog_us_ = 5000;
    std::uint64_t unsent_ = 0;
    std::uint32_t ticks_ = 0;

    mutable LatestValue<Snapshot> snapshot_;
    std::atomic<double> delay_s_{0.0};
};

} // namespace springdrive::usb
