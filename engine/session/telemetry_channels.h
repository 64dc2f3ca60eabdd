// The channels that are kept of each tick: all telemetry columns, and quantities derived from them.
//
//   ServoSample ──► ChannelRow ──► a row of a ChannelStore ──► sample_at ──► the same ServoSample
#pragma once

#include "device/core/device_description.h"
#include "engine/record/channel_store.h"
#include "engine/servo/servo_sample.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
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

/// Computes all channels of consecutive ticks.
class ChannelRow {
public:
    ChannelRow(const device::PhantomGeometry &geometry, double servo_hz);

    /// From the next sample on: another rate, or another device.
    void set_rate(double servo_hz) { servo_hz_ = servo_hz; }
    void set_device(const device::PhantomGeometry &geometry);
    [[nodiscard]] double servo_hz() const { return servo_hz_; }

    /// One value per channel, NaN where there is none; valid until the next call.
    [[nodiscard]] std::span<const double> of(const servo::ServoSample &sample);

private:
    void derive(const servo::ServoSample &sample);

    device::PhantomGeometry geometry_;
    double servo_hz_;
    Vector3 felt_force_N_{Vector3::Zero()}; ///< rendered force below 30 Hz while touching
    std::vector<double> row_;
};

/// The sample that a row of all channels was made from, with all its bits.
/// @param store  with `channels().size()` channels
/// @param row    must be kept
[[nodiscard]] servo::ServoSample sample_at(const record::ChannelStore &store, std::uint64_t row);

} // namespace springdrive::session
