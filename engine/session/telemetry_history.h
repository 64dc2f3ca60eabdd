// The recent past of everything that the servo measures and computes, for plots.
//
//   ServoSample ──► all telemetry columns + quantities derived from them ──► ChannelStore
#pragma once

#include "device/core/device_file.h"
#include "engine/record/channel_store.h"
#include "engine/servo/servo_sample.h"

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::session {

/// A quantity that is kept, one value per tick.
struct Channel {
    std::string name;  ///< of the telemetry column, or of the derived quantity; ends in its unit
    std::string unit;  ///< SI, "1" if there is none
    std::string about; ///< of derived quantities: what it is; else empty
};

/// A telemetry column is a channel without further code. Derived quantities follow them.
[[nodiscard]] const std::vector<Channel> &channels();

/// The channel's number. Empty if there is none of that name.
[[nodiscard]] std::optional<std::size_t> channel_named(std::string_view name);

/// For use by one thread.
class TelemetryHistory {
public:
    /// Some eight minutes at 1 kHz.
    static constexpr std::size_t kMaxBytes = std::size_t{256} << 20;

    TelemetryHistory(const device::PhantomGeometry &geometry, double servo_hz);

    /// From the next sample on: another rate, or another device, whose time starts anew.
    void set_rate(double servo_hz) { servo_hz_ = servo_hz; }
    void set_device(const device::PhantomGeometry &geometry);

    void add(const servo::ServoSample &sample);

    /// Its time is that of the servo, and goes on after an exchange of the device. A copy is a
    /// snapshot.
    [[nodiscard]] const record::ChannelStore &store() const { return store_; }
    [[nodiscard]] double servo_hz() const { return servo_hz_; }

private:
    void derive(const servo::ServoSample &sample);

    device::PhantomGeometry geometry_;
    double servo_hz_;
    double start_s_ = 0.0;                  ///< of the present device's time
    Vector3 felt_force_N_{Vector3::Zero()}; ///< rendered force below 30 Hz while touching
    std::vector<double> row_;
    record::ChannelStore store_;
};

} // namespace springdrive::session
