#include "engine/lab/rig/ringdown.h"

#include <algorithm>
#include <cmath>

namespace springdrive::rig {

namespace {

/// Of the logarithm, over the second half of the samples: what neither doubled nor fell to a third
/// is undecided. A slowly growing motion may long be hidden by others that decay.
constexpr double kClearlyGrows = 0.7;
constexpr double kClearlyFalls = 1.2;

/// A motion is sustained where so many windows differ by less than this share of them: with a decay
/// of 0.2/s they would differ by a fifth.
constexpr std::size_t kRounds = 10;
constexpr double kSteady = 0.02;

} // namespace

Ringdown::Ringdown(const RingdownOptions &options, double period_s)
    : options_(options), period_s_(period_s) {
    constexpr double kMinWindows = 6.0;
    const double window_s = std::min(options.window_s, options.longest_s / kMinWindows);
    per_window_ =
        std::max<std::size_t>(8, static_cast<std::size_t>(std::lround(window_s / period_s)));
    max_windows_ = static_cast<std::size_t>(std::lround(options.longest_s / window_s));
    extended_windows_ = std::max(
        max_windows_, static_cast<std::size_t>(std::lround(options.extension_s / window_s)));
    windows_.reserve(extended_windows_);
}

bool Ringdown::watch(double magnitude) {
    if (magnitude == 0.0 && windows_.empty() && in_window_ == 0) {
        return ++waited_ < per_window_ * max_windows_;
    }
    so_far_ = std::isfinite(magnitude) ? std::max(so_far_, magnitude) : HUGE_VAL;
    ++in_window_;
    if (early_count_ < std::max<std::size_t>(1, per_window_ / 10)) {
        early_ = so_far_;
        ++early_count_;
    }
    if (in_window_ < per_window_ && std::isfinite(so_far_) && so_far_ <= options_.maximum) {
        return true;
    }
    windows_.push_back(so_far_);
    in_window_ = 0;
    so_far_ = 0.0;
    const bool in_time =
        windows_.size() < max_windows_ || (windows_.size() < extended_windows_ && is_unclear());
    return in_time && !goes_round() && last() > options_.died_out * windows_.front() && !ran_away();
}

bool Ringdown::is_unclear() const {
    if (options_.min_decay_per_s > 0.0) {
        return dies_out(); // decaying, by its slope
    }
    const double change = change_of_logarithm();
    return change < kClearlyGrows && change > -kClearlyFalls;
}

double Ringdown::change_of_logarithm() const {
    const auto half = static_cast<double>(windows_.size() - second_half());
    return growth_per_s() * half * window_s();
}

bool Ringdown::stays() const {
    constexpr double kTenth = 0.1;
    return options_.min_decay_per_s == 0.0 && options_.extension_s > 0.0 &&
           windows_.size() >= extended_windows_ && std::abs(change_of_logarithm()) < kTenth;
}

bool Ringdown::goes_round() const {
    if (options_.min_decay_per_s == 0.0 || windows_.size() < kRounds) {
        return false;
    }
    const auto [minimum, maximum] =
        std::minmax_element(windows_.end() - static_cast<std::ptrdiff_t>(kRounds), windows_.end());
    return *maximum - *minimum < kSteady * *maximum;
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
    const double minimum = options_.min_decay_per_s;
    return !ran_away() && !goes_round() && growth_per_s() < -minimum &&
           (minimum == 0.0 || last() < 0.5 * first);
}

double Ringdown::growth_per_s() const {
    if (windows_.size() < 2 || !std::isfinite(last())) {
        return std::isfinite(last()) ? 0.0 : HUGE_VAL;
    }
    const std::size_t begin = second_half();
    const auto count = static_cast<double>(windows_.size() - begin);
    const double middle = 0.5 * (count - 1.0);
    double slope = 0.0;
    double squares = 0.0;
    for (std::size_t i = begin; i < windows_.size(); ++i) {
        const double at = static_cast<double>(i - begin) - middle;
        slope += at * std::log(std::max(windows_[i], 1e-300));
        squares += at * at;
    }
    return squares > 0.0 ? slope / squares / window_s() : 0.0;
}

std::size_t Ringdown::second_half() const {
    return std::min(windows_.size() / 2, windows_.size() - 2);
}

} // namespace springdrive::rig
