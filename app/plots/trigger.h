// The trigger of an oscilloscope, fed tick by tick: `EdgeDetector` finds events in a signal,
// `Trigger` collects the time around one of them.
//
//                      event                event
//                        ╭───╮  ╭─╮           ╭────
//   level               ╌│╌╌╌│╌╌│╌│╌╌╌╌╌╌╌╌╌╌╌│╌╌╌╌
//                        │   ╰──╯ ╰─╮         │
//   level − hysteresis  ╌│╌╌╌╌╌╌╌╌╌╌│╌╌╌╌╌╌╌╌╌│╌╌╌╌
//                      ──╯          ╰─────────╯        on the rising edge
#pragma once

#include <cstdint>
#include <limits>
#include <optional>

namespace springdrive::signals {

enum class TriggerEdge : std::uint8_t { rising, falling, either, change };

/// What counts as an event. A value is high above `level`, and low at it: with level 0 a force that
/// rests at 0 triggers both when contact begins and when it ends.
///
/// rising   from `level − hysteresis` or less to high
/// falling  from above `level + hysteresis` to low
/// either   both, each with its own hysteresis
/// change   to any other value; level and hysteresis are ignored
///
/// A signal that passes the level once triggers once, despite noise on it up to the hysteresis,
/// peak to peak.
struct TriggerCondition {
    TriggerEdge edge = TriggerEdge::rising;
    double level = 0.0;
    double hysteresis = 0.0; ///< not negative
};

/// To be fed with every value, also while its events are ignored. NaN is passed over: neither an
/// event nor a change, whatever comes before or after it.
class EdgeDetector {
public:
    explicit EdgeDetector(const TriggerCondition &condition);

    /// Whether this value is an event; never the first one. RT-safe.
    [[nodiscard]] bool take(double value) noexcept;

    /// Forgets all values.
    void reset() noexcept;

private:
    [[nodiscard]] bool rises(double value) noexcept;
    [[nodiscard]] bool falls(double value) noexcept;
    [[nodiscard]] bool changes(double value) noexcept;

    TriggerCondition condition_;
    bool armed_to_rise_ = false;
    bool armed_to_fall_ = false;
    double last_ = std::numeric_limits<double>::quiet_NaN(); ///< NaN before the first value
};

enum class TriggerMode : std::uint8_t { single, repeating };
enum class TriggerState : std::uint8_t { waiting, collecting, complete };

struct TriggerSettings {
    TriggerMode mode = TriggerMode::single;
    double pre_s = 0.0;     ///< shown before the event
    double post_s = 0.0;    ///< and after it
    double holdoff_s = 0.0; ///< from one event to the next, at least
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
    void arm() noexcept;

    /// To be called when the window of a complete acquisition has been used: if repeating, waits
    /// for the next event after the hold-off, otherwise stays complete.
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
    double held_off_until_s_ = -std::numeric_limits<double>::infinity();
};

} // namespace springdrive::signals
