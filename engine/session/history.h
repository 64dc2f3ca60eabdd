// The last seconds of the plotted quantities.
#pragma once

#include "base/vector.h"
#include "engine/servo/servo_sample.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace springdrive::session {

struct PlotSample {
    double time_s = 0.0;
    double used_error_deg = 0.0;  ///< rendered force to normal, active map; NaN when free
    double felt_error_deg = 0.0;  ///< the same for the force below 30 Hz
    double other_error_deg = 0.0; ///< of the other map in the same state
    double force_N = 0.0;         ///< rendered force
};

/// A ring buffer of at most 1000 samples per second.
class History {
public:
    /// @param servo_hz  within the range that `servo_period_s` allows
    explicit History(double servo_hz) { set_rate(servo_hz); }

    /// Changes the rate from the next sample on; keeps the history.
    void set_rate(double servo_hz);

    void add(const servo::ServoSample &sample);

    [[nodiscard]] std::size_t size() const { return size_; }

    /// Index 0 is the oldest sample.
    [[nodiscard]] const PlotSample &operator[](std::size_t index) const {
        return samples_[(next_ + samples_.size() - size_ + index) % samples_.size()];
    }

private:
    [[nodiscard]] PlotSample plotted(const servo::ServoSample &sample);
    void keep(const PlotSample &sample);

    double servo_hz_ = 0.0;
    std::uint64_t stride_ = 1;              ///< ticks per plotted sample
    Vector3 felt_force_N_{Vector3::Zero()}; ///< rendered force below 30 Hz while touching
    std::vector<PlotSample> samples_;
    std::size_t next_ = 0;
    std::size_t size_ = 0;
};

} // namespace springdrive::session
