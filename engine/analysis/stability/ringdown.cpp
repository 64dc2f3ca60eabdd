#include "engine/analysis/stability/ringdown.h"

#include <algorithm>
#include <cmath>

namespace springdrive {

Ringdown::Ringdown(const RingdownOptions &options, double period_s)
    : options_(options), period_s_(period_s) {
    constexpr double kLeastWindows = 6.0;
    const double window_s = std::min(options.window_s, options.longest_s / kLeastWindows);
    per_window_ =
        std::max<std::size_t>(8, static_cast<std::size_t>(std::lround(window_s / period_s)));
    most_windows_ = static_cast<std::size_t>(std::lround(options.longest_s / window_s));
    windows_.reserve(most_windows_);
}

bool Ringdown::watch(double magnitude) {
    if (magnitude == 0.0 && windows_.empty() && in_window_ == 0) {
        return ++waited_ < per_window_ * most_windows_;
    }
    so_far_ = std::isfinite(magnitude) ? std::max(so_far_, magnitude) : HUGE_VAL;
    ++in_window_;
    if (early_count_ < std::max<std::size_t>(1, per_window_ / 10)) {
        early_ = so_far_;
        ++early_count_;
    }
    if (in_window_ < per_window_ && std::isfinite(so_far_) && so_far_ <= options_.greatest) {
        return true;
    }
    windows_.push_back(so_far_);
    in_window_ = 0;
    so_far_ = 0.0;
    return windows_.size() < most_windows_ && last() > options_.died_out * windows_.front() &&
           !ran_away();
}

bool Ringdown::dies_out() const {
    if (windows_.empty()) {
        return true;
    }
    if (!std::isfinite(last())) {
        return false;
    }
    const double first = windows_.front();
    if (last() <= options_.died_out * first) {
        return true;
    }
    const double least = options_.least_decay_per_s;
    return !ran_away() && growth_per_s() < -least && (least == 0.0 || last() < 0.5 * first);
}

double Ringdown::growth_per_s() const {
    if (windows_.size() < 2 || !std::isfinite(last())) {
        return std::isfinite(last()) ? 0.0 : HUGE_VAL;
    }
    const std::size_t begin = std::min(windows_.size() / 2, windows_.size() - 2);
    const auto count = static_cast<double>(windows_.size() - begin);
    const double middle = 0.5 * (count - 1.0);
    double slope = 0.0;
    double squares = 0.0;
    for (std::size_t i = begin; i < windows_.size(); ++i) {
        const double at = static_cast<double>(i - begin) - middle;
        slope += at * std::log(std::max(windows_[i], 1e-300));
        squares += at * at;
    }
    const double window_s = static_cast<double>(per_window_) * period_s_;
    return squares > 0.0 ? slope / squares / window_s : 0.0;
}

} // namespace springdrive
