// The last seconds of what the panels plot.
#pragma once

#include "engine/servo/servo_sample.h"

#include <algorithm>
#include <cstddef>
#include <vector>

namespace springdrive {

struct PlotSample {
    double time_s = 0.0;
    double used_error_deg = 0.0;  ///< rendered force to normal, map in use; NaN when free
    double felt_error_deg = 0.0;  ///< the same of the force below 30 Hz
    double other_error_deg = 0.0; ///< what the other map would give on the same state
    double force_N = 0.0;         ///< rendered
};

/// A ring that forgets the oldest.
class History {
public:
    explicit History(std::size_t capacity) : samples_(std::max<std::size_t>(1, capacity)) {}

    void add(const PlotSample &sample) {
        samples_[next_] = sample;
        next_ = (next_ + 1) % samples_.size();
        size_ = std::min(size_ + 1, samples_.size());
    }

    [[nodiscard]] std::size_t size() const { return size_; }

    /// 0 is the oldest.
    [[nodiscard]] const PlotSample &operator[](std::size_t index) const {
        return samples_[(next_ + samples_.size() - size_ + index) % samples_.size()];
    }

private:
    std::vector<PlotSample> samples_;
    std::size_t next_ = 0;
    std::size_t size_ = 0;
};

} // namespace springdrive
