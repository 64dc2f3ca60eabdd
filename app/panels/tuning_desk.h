// How the window's user changes the tuning: with undo, two slots to compare, a lamp that shows the
// predicted stability, and a lock at the predicted limit.
//
//   slider, preset, file, key ──► lock ──► TuningHistory ──► servo
//                                  ▲
//                        lamp: the chosen hand's loops
#pragma once

#include "engine/lab/loops/stability_case.h"
#include "engine/session/session.h"
#include "engine/session/tuning_history.h"

#include <array>
#include <cstdint>
#include <optional>
#include <string>

namespace springdrive::app {

/// For whom the lamp predicts.
enum class LampHand : std::uint8_t { every, none, light, relaxed, firm };

inline constexpr std::array<const char *, 5> kLampHandLabels{"every hand", "no hand", "light hand",
                                                             "relaxed hand", "firm hand"};

/// The stability of the active tuning at the present configuration, with the chosen hand.
struct StabilityLamp {
    loops::WorstMember worst;
    double period_s = 1e-3;

    [[nodiscard]] bool is_stable() const { return worst.is_stable(); }
    /// Time in which a motion decays, or grows, by a factor of e.
    [[nodiscard]] double time_constant_s() const;
};

/// The current loop: at the present configuration, with this tuning.
[[nodiscard]] loops::StabilityCase stability_case_of(const session::Session &session,
                                                     const control::Tuning &tuning);

class TuningDesk {
public:
    explicit TuningDesk(const session::Session &session);

    /// Once per frame: the lamp, and tunings that became active otherwise, by a scene's model.
    void update(const session::Session &session);

    /// A control that is held changes the tuning; see TuningHistory. Where the lock stops it, it
    /// goes as far as is stable.
    /// @param source  the control, not 0
    void drag(session::Session &session, const control::Tuning &to, std::uint32_t source);
    /// No control is held any more.
    void let_go() { history_.let_go(); }

    /// A deliberate single change. @param what  its name in the history
    void replace(session::Session &session, const control::Tuning &to, const std::string &what);

    // By key or button.
    void undo(session::Session &session);
    void redo(session::Session &session);
    void toggle_slot(session::Session &session);
    /// Puts the active tuning into the other slot, too.
    void store(session::Session &session);
    void toggle_map(session::Session &session);

    [[nodiscard]] const session::TuningHistory &history() const { return history_; }
    [[nodiscard]] const control::Tuning &now() const { return history_.now(); }
    [[nodiscard]] const StabilityLamp &lamp() const { return lamp_; }

    /// What stopped the last change, or why it was not made; empty if nothing did.
    [[nodiscard]] const std::string &complaint() const { return complaint_; }

    LampHand hand = LampHand::every;
    bool is_unlocked = false; ///< tunings beyond the predicted limit may be set

private:
    void apply(session::Session &session);
    [[nodiscard]] StabilityLamp lamp_of(const session::Session &session,
                                        const control::Tuning &tuning) const;
    /// Whether 2 % more K_P and K_D would make it unstable.
    [[nodiscard]] bool is_behind_lock(const session::Session &session,
                                      const control::Tuning &tuning) const;
    [[nodiscard]] bool is_refused(const session::Session &session, const control::Tuning &to) const;
    /// Otherwise complains. @param what  was to be done
    [[nodiscard]] bool may_go_to(const session::Session &session, const control::Tuning &to,
                                 const char *what);

    session::TuningHistory history_;
    StabilityLamp lamp_;
    std::string complaint_;
};

} // namespace springdrive::app
