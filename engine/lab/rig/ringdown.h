// Decides from a motion alone whether it decays, or has decayed to chatter: no model, only samples.
#pragma once

#include "base/vector.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace springdrive::rig {

struct RingdownOptions {
    /// The window whose greatest value counts: half a period of the slowest oscillation that is to
    /// be judged, or a sixth of the time watched.
    double window_s = 0.1;
    double longest_s = 3.0; ///< to watch
    /// Additional time for a motion that is undecided by then; 0: none. Without a least decay that
    /// is one that has neither doubled nor fallen to a third over the second half of the samples,
    /// with one a motion that falls but is not at rest.
    double extension_s = 0.0;
    /// Motions that end below this share of their beginning have decayed.
    double died_out = 1e-6;
    /// Those that exceed their own first tenth of a window by this factor have run away.
    double ran_away = 1e3;
    double maximum = HUGE_VAL; ///< a motion that exceeds this has run away, too
    /// A motion that decays more slowly than this, or is still above half of its beginning, is
    /// sustained [1/s].
    double min_decay_per_s = 0.0;
};

/// Watches one quantity that is zero at rest, sample by sample, from its first nonzero sample: an
/// initial delay does not count.
class Ringdown {
public:
    Ringdown(const RingdownOptions &options, double period_s);

    /// Adds the next sample's magnitude. Returns whether more samples are needed.
    bool watch(double magnitude);

    /// Whether the motion decays. Where it neither decayed nor ran away, the straight line through
    /// the logarithms of the second half of the windows decides.
    [[nodiscard]] bool dies_out() const;

    /// Whether all of the additional time was needed, and yet the motion changed by less than a
    /// tenth over the second half of it. Without a least decay only.
    [[nodiscard]] bool stays() const;

    /// Slope of that line [1/s]: growth if positive.
    [[nodiscard]] double growth_per_s() const;

    /// The greatest of the last whole window.
    [[nodiscard]] double last() const { return windows_.empty() ? so_far_ : windows_.back(); }

private:
    [[nodiscard]] bool ran_away() const {
        return last() > std::min(options_.ran_away * early_, options_.maximum);
    }
    [[nodiscard]] std::size_t second_half() const; ///< where it begins in `windows_`
    [[nodiscard]] bool is_unclear() const;
    [[nodiscard]] double change_of_logarithm() const; ///< over the second half
    [[nodiscard]] bool goes_round() const;            ///< constant amplitude, as of a limit cycle
    [[nodiscard]] double window_s() const { return static_cast<double>(per_window_) * period_s_; }

    RingdownOptions options_;
    double period_s_;
    std::size_t per_window_ = 8;
    std::size_t max_windows_ = 6;
    std::size_t extended_windows_ = 6;
    std::size_t waited_ = 0;      ///< samples before anything moved
    std::size_t early_count_ = 0; ///< samples in `early_`
    std::vector<double> windows_; ///< the greatest magnitude of each
    double early_ = 0.0;
    double so_far_ = 0.0;
    std::size_t in_window_ = 0;
};

/// Whether a motion has decayed to chatter within the last counts of an encoder, however fast: a
/// limit cycle of quantisation, not an instability of the loop.
class QuantisationChatter {
public:
    /// @param max_range_rad  the largest peak-to-peak amplitude
    /// @param lasting_s  for how long it must not have been exceeded
    QuantisationChatter(double max_range_rad, double lasting_s, double period_s)
        : max_range_rad_(max_range_rad), lasting_(std::ceil(lasting_s / period_s)) {}

    /// Adds the next sample's angles. Where they exceed the amplitude, the count restarts.
    void watch(const Vector3 &angles_rad) {
        min_rad_ = min_rad_.cwiseMin(angles_rad);
        max_rad_ = max_rad_.cwiseMax(angles_rad);
        samples_ += 1.0;
        began_anew_ =
            !angles_rad.allFinite() || !((max_rad_ - min_rad_).maxCoeff() <= max_range_rad_);
        if (began_anew_) {
            min_rad_ = max_rad_ = angles_rad;
            samples_ = 1.0;
        }
    }

    /// Whether there was only chatter for long enough.
    [[nodiscard]] bool is_all() const { return samples_ >= lasting_; }

    /// Whether there is only chatter now, for however short a time.
    [[nodiscard]] bool may_be_all() const { return !began_anew_; }

private:
    double max_range_rad_;
    double lasting_; ///< samples
    Vector3 min_rad_{Vector3::Constant(HUGE_VAL)};
    Vector3 max_rad_{Vector3::Constant(-HUGE_VAL)};
    double samples_ = 0.0; ///< in a row
    bool began_anew_ = false;
};

} // namespace springdrive::rig
