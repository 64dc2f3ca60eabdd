#include "engine/session/tuning_history.h"

#include "engine/control/tuning.h"

#include <fmt/core.h>

#include <utility>

namespace springdrive::session {

TuningHistory::TuningHistory(const control::Tuning &first, double time_s, Publish publish)
    : slots_(first), publish_(std::move(publish)) {
    note(time_s, time_s, "start");
}

void TuningHistory::go_to(const TuningSlots &slots) {
    const bool is_new = slots.now() != now();
    slots_ = slots;
    if (is_new && publish_) {
        publish_(now());
    }
}

// `to` may be a tuning of a step that `let_go` forgets: it is copied first.
void TuningHistory::change(const control::Tuning &to, double time_s, std::uint32_t source) {
    TuningSlots after = slots_;
    after.set(to);
    if (after == slots_) {
        return;
    }
    if (source != source_) {
        let_go();
    }
    if (!drag_) {
        drag_.emplace(TuningStep{time_s, time_s, slots_, slots_, ""});
        source_ = source;
    }
    drag_->time_s = time_s;
    go_to(after);
    if (source == 0) {
        let_go();
    }
}

void TuningHistory::let_go() {
    if (!drag_) {
        return;
    }
    TuningStep step = std::move(*drag_);
    drag_.reset();
    if (step.before == slots_) {
        note(step.began_s, step.time_s, "moved and moved back");
        return;
    }
    step.after = slots_;
    step.what = control::text_of(control::changes_between(step.before.now(), step.after.now()));
    add(std::move(step));
}

void TuningHistory::replace(const control::Tuning &to, double time_s, std::string what) {
    TuningSlots after = slots_;
    after.set(to);
    let_go();
    if (after != slots_) {
        add({time_s, time_s, slots_, after, std::move(what)});
    }
}

void TuningHistory::toggle(double time_s) {
    let_go();
    TuningSlots after = slots_;
    after.toggle();
    add({time_s, time_s, slots_, after,
         fmt::format("{} → {}", name_of(slots_.active()), name_of(after.active()))});
}

void TuningHistory::store(double time_s) {
    let_go();
    TuningSlots after = slots_;
    after.store();
    if (after != slots_) {
        add({time_s, time_s, slots_, after,
             fmt::format("{} stored in {}", name_of(slots_.active()), name_of(slots_.inactive()))});
    }
}

const control::Tuning &TuningHistory::undo(double time_s) {
    let_go();
    if (done_ > 0) {
        const TuningStep &step = steps_[--done_];
        go_to(step.before);
        note(time_s, time_s, "undo: " + step.what);
    }
    return now();
}

const control::Tuning &TuningHistory::redo(double time_s) {
    let_go();
    if (done_ < steps_.size()) {
        const TuningStep &step = steps_[done_++];
        go_to(step.after);
        note(time_s, time_s, "redo: " + step.what);
    }
    return now();
}

void TuningHistory::add(TuningStep step) {
    go_to(step.after);
    note(step.began_s, step.time_s, step.what);
    steps_.erase(steps_.begin() + static_cast<std::ptrdiff_t>(done_), steps_.end());
    steps_.push_back(std::move(step));
    if (steps_.size() > kMaxSteps) {
        steps_.pop_front();
    }
    done_ = steps_.size();
}

void TuningHistory::note(double began_s, double time_s, std::string what) {
    journal_.push_back({began_s, time_s, std::move(what), now()});
    if (journal_.size() > kMaxEvents) {
        journal_.pop_front();
    }
}

} // namespace springdrive::session
