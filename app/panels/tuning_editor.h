// The tunings that the window offers, and the editor through which its user changes the tuning:
// with undo, two slots to compare, an indicator of the predicted stability, and a lock at the
// predicted limit.
//
//   slider, preset, file, key ──► lock ──► the session's TuningHistory ──► servo
//                                  ▲
//                        indicator: the loops of the chosen hand
#pragma once

#include "engine/control/tuning_file.h"
#include "engine/lab/loops/stability_case.h"
#include "engine/session/session.h"
#include "engine/session/tuning_history.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::app {

/// A stored tuning that has a button in the tuning panel.
struct Preset {
    std::string_view label; ///< on its button, which several presets may share
    std::string_view file;  ///< in assets/tunings, without its extension
    /// The lowest servo rate, without delay, at which it is meant to be used; 0: any rate and
    /// delay.
    double min_servo_hz = 0.0;
};

/// The presets; those of one label are in order of rising servo rate.
inline constexpr std::array<Preset, 4> kPresets{{
    {"soft", "soft"},
    {"firm", "firm"},
    {"stiffest", "stiffest_1kHz", 1000.0},
    {"stiffest", "stiffest_4kHz", 4000.0},
}};

/// The labels of the presets, one button each.
inline constexpr std::array<const char *, 3> kPresetLabels{"soft", "firm", "stiffest"};

/// The file of the preset with this label that is meant for the highest rate up to the servo's.
/// Empty where none is meant for this servo.
[[nodiscard]] std::string preset_file(std::string_view label, double servo_hz,
                                      double delay_periods);

/// The tuning files of the user, which are in `output_dir`, and of the project.
class TuningFiles {
public:
    struct Entry {
        std::filesystem::path file;
        std::string name; ///< without its extension; a file of the project has it in brackets
        control::TuningFile contents;
        bool is_own = false; ///< the user's
    };

    TuningFiles() { refresh(); }

    /// Lists the files anew; those that hold no tuning are left out.
    void refresh();

    [[nodiscard]] const std::vector<Entry> &entries() const { return entries_; }

    /// Writes NAME.toml to `output_dir`. @return the outcome, as a text for the user
    std::string save(const std::string &name, const control::Tuning &tuning);

    /// Renames a file of the user. @return the outcome, as a text for the user
    std::string rename(Entry entry, const std::string &name);

private:
    std::vector<Entry> entries_;
};

/// The hand for which the indicator predicts; `every` is the whole family of hands.
enum class IndicatorHand : std::uint8_t { every, none, light, relaxed, firm };

inline constexpr std::array<const char *, 5> kIndicatorHandLabels{
    "every hand", "no hand", "light hand", "relaxed hand", "firm hand"};

/// The stability of the active tuning at the present configuration, with the chosen hand.
struct StabilityIndicator {
    loops::WorstMember worst; ///< the loop of a motor and a hand that decays most slowly
    double period_s = 1e-3;   ///< of the servo
    bool is_passive = false;  ///< whatever the hand, see loops/passivity.h

    [[nodiscard]] bool is_stable() const { return worst.is_stable(); }

    /// Time in which that loop's motion decays, or grows, by a factor of e.
    [[nodiscard]] double time_constant_s() const;
};

/// The loop at the present configuration of the session's device, with this tuning.
[[nodiscard]] loops::StabilityCase stability_case_of(const session::Session &session,
                                                     const control::Tuning &tuning);

/// Changes a session's tuning, unless the lock refuses the change.
class TuningEditor {
public:
    /// @param session  must outlive it
    explicit TuningEditor(session::Session &session) : session_(session) {}

    /// Updates the indicator; called once a frame.
    void update();

    /// Changes the tuning by a control that is being dragged, as far as the lock allows; see
    /// TuningHistory.
    /// @param source  identifies the control; not 0
    void drag(const control::Tuning &to, std::uint32_t source);

    /// Changes the tuning in one step.
    /// @param what  the name of the step in the history
    void replace(const control::Tuning &to, const std::string &what);

    // Single steps, each by a key or a button.

    void undo();
    void redo();
    void toggle_slot();
    void toggle_map();

    [[nodiscard]] const StabilityIndicator &indicator() const { return indicator_; }

    /// Why the last change was limited or not made; empty if it was made in full.
    [[nodiscard]] const std::string &error() const { return error_; }

    IndicatorHand hand = IndicatorHand::every;
    bool is_unlocked = false; ///< allows tunings beyond the predicted limit

private:
    [[nodiscard]] session::TuningHistory &history() { return session_.tuning(); }
    [[nodiscard]] const control::Tuning &now() const { return session_.tuning().now(); }
    [[nodiscard]] StabilityIndicator compute_indicator(const control::Tuning &tuning) const;

    /// Whether the loop is unstable with kLockMargin times the tuning's K_P and K_D.
    [[nodiscard]] bool exceeds_gain_margin(const control::Tuning &tuning) const;

    /// Whether the lock forbids the tuning: it exceeds the gain margin, and the present tuning does
    /// not, or is more stable.
    [[nodiscard]] bool is_refused(const control::Tuning &to) const;

    /// Whether the tuning is valid and not refused; if not, sets `error`.
    /// @param what  the name of the change in that error
    [[nodiscard]] bool may_go_to(const control::Tuning &to, const char *what);

    session::Session &session_;
    StabilityIndicator indicator_;
    std::string error_;
};

} // namespace springdrive::app
