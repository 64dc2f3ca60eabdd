// The past of everything that the servo measures and computes, in memory: for plots, playback, kept
// sessions and what could have been.
//
//   ServoSample ──► all telemetry columns + quantities derived from them ──► ChannelStore
//   a row of the ChannelStore ──► sample_at ──► the same ServoSample
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
#include <utility>
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

/// The channels of consecutive samples. For use by one thread.
class TelemetryHistory {
public:
    /// Some eight minutes at 1 kHz.
    static constexpr std::size_t kMaxBytes = std::size_t{256} << 20;

    TelemetryHistory(const device::PhantomGeometry &geometry, double servo_hz,
                     std::size_t max_bytes = kMaxBytes);

    /// From the next sample on: another rate, or another device, whose time starts anew.
    void set_rate(double servo_hz) { servo_hz_ = servo_hz; }
    void set_device(const device::PhantomGeometry &geometry);
    /// Takes the rate from the time since the sample before, if that differs: for records.
    void follow_rate(const servo::ServoSample &next);

    void add(const servo::ServoSample &sample) {
        store_.add(start_s_ + sample.time_s, row_of(sample));
    }
    /// The channels of the next sample, without keeping them: NaN where there is no value. Valid
    /// until the next call.
    std::span<const double> row_of(const servo::ServoSample &sample);

    /// Its time is that of the servo, and goes on after an exchange of the device. A copy is a
    /// snapshot.
    [[nodiscard]] const record::ChannelStore &store() const { return store_; }
    [[nodiscard]] record::ChannelStore take() && { return std::move(store_); }
    /// The store's time at which the time of the present device was 0.
    [[nodiscard]] double start_s() const { return start_s_; }
    [[nodiscard]] double servo_hz() const { return servo_hz_; }

private:
    void derive(const servo::ServoSample &sample);

    device::PhantomGeometry geometry_;
    double servo_hz_;
    Vector3 felt_force_N_{Vector3::Zero()};  ///< rendered force below 30 Hz while touching
    std::optional<std::uint64_t> last_tick_; ///< of the previous sample
    double last_s_ = 0.0;                    ///< its time
    std::vector<double> row_;
    double start_s_ = 0.0; ///< of the present device's time
    record::ChannelStore store_;
};

/// The sample that a row of all channels was made from, with all its bits.
/// @param store  with `channels().size()` channels
/// @param row    must be kept
[[nodiscard]] servo::ServoSample sample_at(const record::ChannelStore &store, std::uint64_t row);

} // namespace springdrive::session
