// The tools of an oscilloscope: the spectrum of a signal, a histogram of its values, and a trigger
// that is fed tick by tick.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

namespace springdrive::signals {

/// The spectrum of an evenly sampled signal, by Welch's method: the mean is removed, segments that
/// overlap by half are weighted with a Hann window, and the powers of their transforms are
/// averaged. One-sided: bin i is at i · bin_Hz, the last one at half the sample rate. All empty or
/// 0 if there are too few samples.
///
/// A sine and noise need different scales: a longer segment leaves the amplitude of a sine as it
/// is, but spreads noise over more bins. So there are two readings of one spectrum:
///
///   amplitude         A sine shows its amplitude in its bin and half of it in both neighbours.
///                     Between two bins, the nearer one shows up to 1.42 dB less: a factor of
///                     0.849.
///   density_per_rtHz  White noise of standard deviation σ shows σ √(2/sample rate), whatever the
///                     length. Σ density² bin_Hz is the variance, of sines too.
///
/// Noise also reads as an amplitude: except at both ends, density √(2 resolution_Hz).
struct Spectrum {
    double bin_Hz = 0.0;
    std::vector<double> amplitude;        ///< of a sine, in the signal's unit
    std::vector<double> density_per_rtHz; ///< root of the power spectral density [unit/√Hz]
    std::size_t segments = 0;             ///< averaged; the spread of noise falls with their number
    double resolution_Hz = 0.0;           ///< noise bandwidth of a bin: 1.5 bins
};

/// Uses the longest run of finite values, the first of several: all others are gaps. Segments are
/// the longest power of two of which 8 fit into it, but not shorter than 64 samples: fewer than 8
/// segments from less than 288 samples, none from less than 64. Up to half a segment at the end is
/// left out. The mean is that of the run, so that drift from segment to segment stays visible in
/// the lowest bins. @pre sample_rate_hz > 0
[[nodiscard]] Spectrum amplitude_spectrum(std::span<const double> values, double sample_rate_hz);

/// How often a signal has which values, in bins of equal width. A value on the edge of two bins
/// counts in the upper one, at `to` in the last one. Every number is counted once: in a bin, below
/// or above; NaN is not.
struct ValueHistogram {
    double from = 0.0;
    double to = 0.0;
    std::vector<std::uint64_t> counts; ///< of each bin
    std::uint64_t below = 0;
    std::uint64_t above = 0;

    [[nodiscard]] double bin_width() const {
        return (to - from) / static_cast<double>(counts.size());
    }
    /// Where a bin begins.
    [[nodiscard]] double edge(std::size_t bin) const {
        return from + static_cast<double>(bin) * bin_width();
    }
};

/// The range goes from the 0.1 % to the 99.9 % quantile of the values, so that outliers do not hide
/// the rest. Bins are 1, 2 or 5 times a power of ten wide, their edges multiples of that, and they
/// are as narrow as `max_bins` allows. Where all values are equal, or differ by less than 1e-9 of
/// their size, the range is widened by 10 % to both sides, around 0 by 1. Without values it is that
/// around 0. Magnitudes above 1e300 are treated like infinities.
/// @pre 2 to 10'000 bins
[[nodiscard]] ValueHistogram histogram(std::span<const double> values, std::size_t max_bins);

enum class TriggerEdge : std::uint8_t { rising, falling, either, change };

/// What counts as an event. A value is high above `level`, and low at it: with level 0 a force that
/// rests at 0 triggers both when contact begins and when it ends.
///
/// rising   from low to high
/// falling  from high to low
/// either   both
/// change   to any other value; the level is ignored
struct TriggerCondition {
    TriggerEdge edge = TriggerEdge::rising;
    double level = 0.0;
};

/// To be fed with every value, also while its events are ignored. NaN is passed over: neither an
/// event nor a change, whatever comes before or after it.
class EdgeDetector {
public:
    explicit EdgeDetector(const TriggerCondition &condition) : condition_(condition) {}

    /// Whether this value is an event; never the first one. RT-safe.
    [[nodiscard]] bool take(double value) noexcept;

private:
    TriggerCondition condition_;
    double last_ = std::numeric_limits<double>::quiet_NaN(); ///< NaN before the first value
};

enum class TriggerMode : std::uint8_t { single, repeating };
enum class TriggerState : std::uint8_t { waiting, collecting, complete };

struct TriggerSettings {
    TriggerMode mode = TriggerMode::single;
    double pre_s = 0.0;  ///< shown before the event
    double post_s = 0.0; ///< and after it
};

/// Both ends are included.
struct TimeWindow {
    double from_s = 0.0;
    double to_s = 0.0;
};

/// Waits for an event, then for the time after it. Events while it collects, or is complete, are
/// ignored.
///
/// Times must not decrease: where they start again, call `arm`.
class Trigger {
public:
    /// @pre no time is negative
    explicit Trigger(const TriggerSettings &settings);

    /// Advances to a tick; `fired` if it has an event. RT-safe.
    void take(double time_s, bool fired) noexcept;

    /// Waits for the next event, at once and whatever the state: a press of a button.
    void arm() noexcept { state_ = TriggerState::waiting; }

    /// To be called when the window of a complete acquisition has been used: if repeating, waits
    /// for the next event, otherwise stays complete.
    void proceed() noexcept;

    [[nodiscard]] TriggerState state() const noexcept { return state_; }

    /// From `pre_s` before the event to `post_s` after it; only once complete. It may begin before
    /// the first tick: an event is valid however early it is.
    [[nodiscard]] std::optional<TimeWindow> window() const noexcept;

private:
    [[nodiscard]] double end_s() const noexcept { return event_s_ + settings_.post_s; }

    TriggerSettings settings_;
    TriggerState state_ = TriggerState::waiting;
    double event_s_ = 0.0; ///< unless waiting
};

} // namespace springdrive::signals
