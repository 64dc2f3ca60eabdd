// The tuning of a session, with undo and redo, two of them to compare, and the journal of a run.
//
//   editor, scene's model, assistant, study ──► TuningHistory ──► servo
//
//   A: t0 ──change──► A: t1 ──toggle──► B: t0 ──change──► B: t2
//                           ◄──undo────       ◄──undo────
#pragma once

#include "engine/control/tuning.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

namespace springdrive::session {

enum class TuningSlot : std::uint8_t { a, b };

/// For people, by their number.
inline constexpr std::array<std::string_view, 2> kTuningSlotNames{"A", "B"};

[[nodiscard]] constexpr std::string_view name_of(TuningSlot slot) {
    return kTuningSlotNames[static_cast<std::size_t>(slot)];
}

/// Two tunings, A and B, to compare by switching between them. Changes go to the active one; the
/// other keeps what it had.
class TuningSlots {
public:
    /// Both equal, A active.
    explicit TuningSlots(const control::Tuning &both) : tuning_{both, both} {}

    [[nodiscard]] TuningSlot active() const { return active_; }
    [[nodiscard]] TuningSlot inactive() const {
        return active_ == TuningSlot::a ? TuningSlot::b : TuningSlot::a;
    }
    [[nodiscard]] const control::Tuning &now() const { return in(active_); }
    [[nodiscard]] const control::Tuning &other() const { return in(inactive()); }

    void set(const control::Tuning &to) { tuning_[static_cast<std::size_t>(active_)] = to; }
    /// Puts the active tuning into the other slot, too.
    void store() { tuning_[static_cast<std::size_t>(inactive())] = now(); }
    void toggle() { active_ = inactive(); }

    friend bool operator==(const TuningSlots &, const TuningSlots &) = default;

private:
    [[nodiscard]] const control::Tuning &in(TuningSlot slot) const {
        return tuning_[static_cast<std::size_t>(slot)];
    }

    std::array<control::Tuning, 2> tuning_;
    TuningSlot active_ = TuningSlot::a;
};

/// One change, as undo takes it back: of a tuning or of the slots.
struct TuningStep {
    double began_s = 0.0; ///< earlier than `time_s` only for a drag
    double time_s = 0.0;  ///< of its last change
    TuningSlots before;
    TuningSlots after;
    std::string what; ///< for people: its name, or what it changed
};

/// One line of the journal: this tuning is active from `time_s` on. From `began_s` to `time_s` it
/// was being dragged there.
struct TuningEvent {
    double began_s = 0.0;
    double time_s = 0.0;
    std::string what;
    control::Tuning tuning;
};

/// Its states are `TuningSlots`. Every change of state is one step, and nothing can be redone after
/// it; what changes nothing is no step. What becomes active is passed on at once. Times are by the
/// caller's clock. For use by one thread.
class TuningHistory {
public:
    /// Beyond these the oldest are forgotten; together they take some 20 MB.
    static constexpr std::size_t kMaxSteps = 10'000;
    static constexpr std::size_t kMaxEvents = 100'000;

    /// Is given each tuning that becomes active.
    using Publish = std::function<void(const control::Tuning &)>;

    explicit TuningHistory(const control::Tuning &first, double time_s = 0.0, Publish publish = {});

    /// A change by a control. Those of a control that is held join one step, a drag, until
    /// `let_go` or another change, undo or redo. A drag that ends where it began is no step, and
    /// keeps what could be redone.
    /// @param source  the control that is held; 0: the change is complete in itself
    void change(const control::Tuning &to, double time_s, std::uint32_t source = 0);

    /// Ends the drag, if there is one: may be called in every frame in which no control is held.
    void let_go();

    /// A change from elsewhere: a preset, a file, a search. @param what  its name in the history
    void replace(const control::Tuning &to, double time_s, std::string what);

    /// Makes the tuning of the other slot the active one.
    void toggle(double time_s);
    /// Puts the active tuning into the other slot, too.
    void store(double time_s);

    [[nodiscard]] bool can_undo() const { return done_ > 0 || has_moved(); }
    [[nodiscard]] bool can_redo() const { return done_ < steps_.size() && !has_moved(); }
    /// End a drag first. Return the tuning that is then active: the same as before if there is
    /// nothing to undo or redo.
    const control::Tuning &undo(double time_s);
    const control::Tuning &redo(double time_s);

    [[nodiscard]] const control::Tuning &now() const { return slots_.now(); }
    [[nodiscard]] const TuningSlots &slots() const { return slots_; }

    /// The steps, oldest first: those before `done()` can be undone, the rest redone. A drag is
    /// included once it has ended.
    [[nodiscard]] const std::deque<TuningStep> &steps() const { return steps_; }
    [[nodiscard]] std::size_t done() const { return done_; }

    /// All that became active, oldest first: "start", every step, undo and redo. A drag is included
    /// once it has ended, also one that is no step: call `let_go` before writing the journal,
    /// which is whole if it begins with "start".
    [[nodiscard]] const std::deque<TuningEvent> &journal() const { return journal_; }

private:
    [[nodiscard]] bool has_moved() const { return drag_ && drag_->before != slots_; }
    void go_to(const TuningSlots &slots);
    void add(TuningStep step);
    void note(double began_s, double time_s, std::string what);

    TuningSlots slots_;
    Publish publish_;
    std::deque<TuningStep> steps_;
    std::size_t done_ = 0;
    std::optional<TuningStep> drag_; ///< the present one; `after` and `what` are not yet known
    std::uint32_t source_ = 0;       ///< the control of the drag
    std::deque<TuningEvent> journal_;
};

} // namespace springdrive::session
