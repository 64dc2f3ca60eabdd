// What a participant is asked, on which scale of levels; and the lines in which a specification is
// refused.
#pragma once

#include "base/field.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>

namespace springdrive::study {

enum class Scale : std::uint8_t {
    linear,      ///< differences count: u = x
    logarithmic, ///< ratios count: u = ln x, so levels are above 0
};

/// By the number of the scale, as in protocol files.
inline constexpr std::array<std::string_view, 2> kScaleNames{"linear", "logarithmic"};

/// Levels and slopes that people type: what lies beyond is a slip of the keyboard in every unit
/// that a protocol has.
inline constexpr double kMaxTyped = 1e6;
inline constexpr double kMinRatioTyped = 1e-6; ///< of what must be above 0
inline constexpr NumberRange kTypedLevel{-kMaxTyped, kMaxTyped};

/// u(x). @pre level > 0 on a logarithmic scale
[[nodiscard]] inline double on_scale(Scale scale, double level) {
    return scale == Scale::linear ? level : std::log(level);
}

/// x(u), the inverse of `on_scale`.
[[nodiscard]] inline double level_from(Scale scale, double on_scale) {
    return scale == Scale::linear ? on_scale : std::exp(on_scale);
}

// The lines in which a specification is refused: key, value and range.

/// "KEY is VALUE; it must be from …" unless it can be a typed level: within `kMaxTyped`, and on
/// a logarithmic scale not below `kMinRatioTyped`.
[[nodiscard]] std::string unless_level(std::string_view key, double value, Scale scale);

/// "KEY is VALUE; it must be a finite number above MINIMUM" if it is not, or not finite; else
/// empty.
[[nodiscard]] std::string unless_above(std::string_view key, double value, double minimum);

/// Refuses levels that are fewer than `fewest`, not finite or not rising; else empty.
[[nodiscard]] std::string unless_rising(std::string_view key, std::span<const double> levels,
                                        std::size_t fewest);

/// Refuses values that are not finite; else empty.
[[nodiscard]] std::string unless_finite(std::string_view key, std::span<const double> values);

/// The first that is not empty.
[[nodiscard]] std::string first_of(std::initializer_list<std::string> errors);

// What a participant is asked to do in each trial.

enum class TaskKind : std::uint8_t {
    forced_choice_by_interval, ///< in which of m intervals of time was the stimulus
    forced_choice_by_place,    ///< at which of m places, or in which of m directions, was it
    yes_no,                    ///< was it there, was it stronger than the standard
    adjustment,                ///< set the level yourself
};

/// By the number of the kind, as in protocol files.
inline constexpr std::array<std::string_view, 4> kTaskKindNames{
    "forced_choice_by_interval", "forced_choice_by_place", "yes_no", "adjustment"};

struct Task {
    TaskKind kind = TaskKind::forced_choice_by_interval;
    int alternatives = 2; ///< m of forced choice, 2 to 8; 2 for the other kinds
    /// Of yes/no: the share of "yes" without a stimulus is not known; it is taken to lie between 0
    /// and this, all values being equally likely before the study. 0: no false alarms.
    double largest_false_alarm_rate = 0.5;

    friend bool operator==(const Task &, const Task &) = default;
};

inline constexpr auto kTaskFields = std::to_array<Field<Task>>({
    {"kind", choice_of<&Task::kind>(kTaskKindNames), "what is asked in a trial", kRequired},
    {"alternatives", &Task::alternatives,
     "intervals, or directions, of a forced choice; 2 otherwise", 2.0, 8.0},
    {"largest_false_alarm_rate", &Task::largest_false_alarm_rate,
     "yes/no: the share of \"yes\" without a stimulus is taken to lie between 0 and this", 0.0,
     0.5},
});

/// Empty if the task can be used; else the first bad key, with value and range.
[[nodiscard]] std::string validate(const Task &task);

[[nodiscard]] constexpr bool is_forced_choice(TaskKind kind) {
    return kind == TaskKind::forced_choice_by_interval || kind == TaskKind::forced_choice_by_place;
}

/// Known bounds of the guess rate γ: 1/m of forced choice, 0 to the largest rate of yes/no.
struct GuessRange {
    double minimum = 0.0;
    double maximum = 0.0;
};
[[nodiscard]] GuessRange guess_range(const Task &task);

// A trial as a method sees it: what it asked for, and what came of it.

/// What is to be presented.
struct MethodTrial {
    double level = 0.0; ///< of an adjustment: where it starts
    int track = 0;      ///< of staircases, else 0

    friend bool operator==(const MethodTrial &, const MethodTrial &) = default;
};

/// What came of a trial.
struct Outcome {
    bool positive = false; ///< correct, or "yes"
    double setting = 0.0;  ///< of an adjustment
    /// The trial did not happen: it tells the method nothing, and is presented again. Constant
    /// stimuli put its level back at a drawn place among those that are left in its block, not the
    /// next one if others are left; an adaptive method asks for the same level when the track has
    /// its next turn; an adjustment starts from the same level again.
    bool marked = false;

    friend bool operator==(const Outcome &, const Outcome &) = default;
};

/// A trial that was run.
struct PastMethodTrial {
    MethodTrial presented;
    Outcome outcome;

    friend bool operator==(const PastMethodTrial &, const PastMethodTrial &) = default;
};

} // namespace springdrive::study
