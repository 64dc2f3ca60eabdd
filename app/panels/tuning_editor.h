// How the window's user changes the tuning: with undo, two slots to compare, an indicator that
// shows the predicted stability, and a lock at the predicted limit; and the tunings that the window
// offers: those in assets/tunings that have a button, all files of the project, and those in the
// own folder.
//
//   slider, preset, file, key ──► lock ──► the session's TuningHistory ──► servo
//                                  ▲
//                        indicator: the chosen hand's loops
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
    std::string_view label; ///< of its button; several may share one
    std::string_view file;  ///< in assets/tunings, without ending
    /// The lowest servo rate, without delay, at which it is meant to be used; 0: any servo.
    double min_servo_hz = 0.0;
};

/// Those of one label by rising servo rate.
inline constexpr std::array<Preset, 4> kPresets{{
    {"soft", "soft"},
    {"firm", "firm"},
    {"stiffest", "stiffest_1kHz", 1000.0},
    {"stiffest", "stiffest_4kHz", 4000.0},
}};

/// Their labels, one button each.
inline constexpr std::array<const char *, 3> kPresetLabels{"soft", "firm", "stiffest"};

/// The file of a button: of the highest rate that is not above the servo's. Empty where there is
/// none for this servo.
[[nodiscard]] std::string preset_file(std::string_view label, double servo_hz,
                                      double delay_periods);

/// The tunings in files.
class TuningFiles {
public:
    TuningFiles() { refresh(); }

    /// Looks again for files; those that are no tunings are left out.
    void refresh();

    struct Entry {
        std::filesystem::path file;
        std::string name; ///< without ending; those of the project in brackets
        control::TuningFile contents;
        bool is_own = false; ///< of the user, in the own folder
    };
    [[nodiscard]] const std::vector<Entry> &entries() const { return entries_; }

    /// Writes NAME.toml to the own folder. @return what happened, for people
    std::string save(const std::string &name, const control::Tuning &tuning);

    /// Renames a file of the user. @return what happened, for people
    std::string rename(Entry entry, const std::string &name);

private:
    std::vector<Entry> entries_;
};

/// For whom the indicator predicts.
enum class IndicatorHand : std::uint8_t { every, none, light, relaxed, firm };

inline constexpr std::array<const char *, 5> kIndicatorHandLabels{
    "every hand", "no hand", "light hand", "relaxed hand", "firm hand"};

/// The stability of the active tuning at the present configuration, with the chosen hand.
struct StabilityIndicator {
    loops::WorstMember worst;
    double period_s = 1e-3;

    [[nodiscard]] bool is_stable() const { return worst.is_stable(); }
    /// Time in which a motion decays, or grows, by a factor of e.
    [[nodiscard]] double time_constant_s() const;
};

/// The current loop: at the present configuration, with this tuning.
[[nodiscard]] loops::StabilityCase stability_case_of(const session::Session &session,
                                                     const control::Tuning &tuning);

class TuningEditor {
public:
    /// @param session  must outlive it
    explicit TuningEditor(session::Session &session) : session_(session) {}

    /// Once per frame: the indicator.
    void update();

    /// A control that is held changes the tuning; see TuningHistory. Where the lock stops it, it
    /// goes as far as is stable.
    /// @param source  the control, not 0
    void drag(const control::Tuning &to, std::uint32_t source);

    /// A deliberate single change. @param what  its name in the history
    void replace(const control::Tuning &to, const std::string &what);

    // By key or button.
    void undo();
    void redo();
    void toggle_slot();
    void toggle_map();

    [[nodiscard]] const StabilityIndicator &indicator() const { return indicator_; }

    /// What stopped the last change, or why it was not made; empty if nothing did.
    [[nodiscard]] const std::string &error() const { return error_; }

    IndicatorHand hand = IndicatorHand::every;
    bool is_unlocked = false; ///< tunings beyond the predicted limit may be set

private:
    [[nodiscard]] session::TuningHistory &history() { return session_.tuning(); }
    [[nodiscard]] const control::Tuning &now() const { return session_.tuning().now(); }
    [[nodiscard]] StabilityIndicator indicator_of(const control::Tuning &tuning) const;
    /// Whether 2 % more K_P and K_D would make it unstable.
    [[nodiscard]] bool exceeds_gain_margin(const control::Tuning &tuning) const;
    [[nodiscard]] bool is_refused(const control::Tuning &to) const;
    /// Otherwise reports an error. @param what  was to be done
    [[nodiscard]] bool may_go_to(const control::Tuning &to, const char *what);

    session::Session &session_;
    StabilityIndicator indicator_;
    std::string error_;
};

} // namespace springdrive::app
