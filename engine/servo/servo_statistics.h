// Timing statistics of a servo, accumulated from its samples by their reader.
#pragma once

#include "engine/servo/duration_histogram.h"
#include "engine/servo/servo_sample.h"

#include <cmath>
#include <cstdint>

namespace springdrive::servo {

class ServoStatistics {
public:
    void add(const ServoSample &sample) noexcept {
        ++ticks_;
        missed_ += sample.missed_deadlines;
        add_if_known(period_, sample.period_s);
        add_if_known(lateness_, sample.lateness_s);
        add_if_known(read_, sample.read_s);
        add_if_known(compute_, sample.compute_s);
        add_if_known(write_, sample.write_s);
    }

    [[nodiscard]] std::uint64_t ticks() const { return ticks_; }
    [[nodiscard]] std::uint64_t missed_deadlines() const { return missed_; }

    /// From the start of a tick to the start of the next.
    [[nodiscard]] const DurationHistogram &period() const { return period_; }
    /// From a tick's deadline to its start: the jitter.
    [[nodiscard]] const DurationHistogram &lateness() const { return lateness_; }
    /// Duration of reading the device.
    [[nodiscard]] const DurationHistogram &read() const { return read_; }
    /// From the measurement to the command computed from it.
    [[nodiscard]] const DurationHistogram &compute() const { return compute_; }
    /// Duration of writing to the device.
    [[nodiscard]] const DurationHistogram &write() const { return write_; }

private:
    static void add_if_known(DurationHistogram &histogram, double duration_s) noexcept {
        if (!std::isnan(duration_s)) {
            histogram.add(duration_s);
        }
    }

    std::uint64_t ticks_ = 0;
    std::uint64_t missed_ = 0;
    DurationHistogram period_;
    DurationHistogram lateness_;
    DurationHistogram read_;
    DurationHistogram compute_;
    DurationHistogram write_;
};

} // namespace springdrive::servo
