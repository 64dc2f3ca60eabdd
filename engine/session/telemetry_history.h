// The recent past of everything that the servo measures and computes, for plots.
//
//   ServoSample ──► all telemetry columns + quantities derived from them ──► ChannelStore
#pragma once

#include "engine/session/telemetry_channels.h"

#include <cstddef>

namespace springdrive::session {

/// For use by one thread.
class TelemetryHistory {
public:
    /// Some eight minutes at 1 kHz.
    static constexpr std::size_t kMaxBytes = std::size_t{256} << 20;

    TelemetryHistory(const device::PhantomGeometry &geometry, double servo_hz,
                     std::size_t max_bytes = kMaxBytes)
        : row_(geometry, servo_hz), store_(channels().size(), max_bytes) {}

    /// From the next sample on: another rate, or another device, whose time starts anew.
    void set_rate(double servo_hz) { row_.set_rate(servo_hz); }
    void set_device(const device::PhantomGeometry &geometry);

    void add(const servo::ServoSample &sample) {
        store_.add(start_s_ + sample.time_s, row_.of(sample));
    }

    /// Its time is that of the servo, and goes on after an exchange of the device. A copy is a
    /// snapshot.
    [[nodiscard]] const record::ChannelStore &store() const { return store_; }
    /// The store's time at which the time of the present device was 0.
    [[nodiscard]] double start_s() const { return start_s_; }
    [[nodiscard]] double servo_hz() const { return row_.servo_hz(); }

private:
    ChannelRow row_;
    double start_s_ = 0.0; ///< of the present device's time
    record::ChannelStore store_;
};

} // namespace springdrive::session
