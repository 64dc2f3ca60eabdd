#include "engine/session/history.h"

#include "base/degrees.h"
#include "engine/control/force_direction.h"
#include "engine/control/perception.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace springdrive::session {

namespace {

constexpr double kPlotted_s = 10.0;
constexpr double kMaxPlotRate_hz = 1000.0;

} // namespace

void History::set_rate(double servo_hz) {
    const double stride = std::max(1.0, std::ceil(servo_hz / kMaxPlotRate_hz));
    const auto capacity = static_cast<std::size_t>(std::max(1.0, kPlotted_s * servo_hz / stride));
    History before = *this;
    servo_hz_ = servo_hz;
    stride_ = static_cast<std::uint64_t>(stride);
    samples_.assign(capacity, {});
    next_ = 0;
    size_ = 0;
    for (std::size_t i = 0; i < before.size(); ++i) {
        keep(before[i]);
    }
}

void History::add(const servo::ServoSample &sample) {
    const PlotSample now = plotted(sample); // on every tick, because of the filter
    if (sample.tick % stride_ == 0) {
        keep(now);
    }
}

void History::keep(const PlotSample &sample) {
    samples_[next_] = sample;
    next_ = (next_ + 1) % samples_.size();
    size_ = std::min(size_ + 1, samples_.size());
}

PlotSample History::plotted(const servo::ServoSample &sample) {
    if (sample.contact.touching) {
        const double pole = std::exp(-2.0 * std::numbers::pi * control::kPerceived_Hz / servo_hz_);
        felt_force_N_ = pole * felt_force_N_ + (1.0 - pole) * sample.tip_force_N;
    } else {
        felt_force_N_.setZero();
    }
    const double felt = std::isnan(sample.rendered_error_rad)
                            ? sample.rendered_error_rad
                            : control::direction_error_rad(felt_force_N_, sample.contact.normal);
    const double other = sample.tuning.map == control::MotionMap::transpose
                             ? sample.inverse_error_rad
                             : sample.transpose_error_rad;
    return {sample.time_s, sample.rendered_error_rad * kDegreesPerRadian, felt * kDegreesPerRadian,
            other * kDegreesPerRadian, sample.tip_force_N.norm()};
}

} // namespace springdrive::session
