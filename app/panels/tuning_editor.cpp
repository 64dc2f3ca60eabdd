#include "app/panels/tuning_editor.h"

#include "base/bisection.h"
#include "base/print.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/tuning_difference.h"

#include <fmt/core.h>

#include <cmath>
#include <utility>

namespace springdrive::app {

namespace {

std::vector<loops::Hand> hands_of(IndicatorHand hand) {
    switch (hand) {
    case IndicatorHand::every:
        break;
    case IndicatorHand::none:
        return {loops::no_hand()};
    case IndicatorHand::light:
        return {loops::hand_of_firmness(0.0)};
    case IndicatorHand::relaxed:
        return {loops::hand_of_firmness(0.5)};
    case IndicatorHand::firm:
        return {loops::hand_of_firmness(1.0)};
    }
    return loops::hand_family();
}

/// On the way from one tuning to another; map and source of α are those of the end.
control::Tuning on_the_way(const control::Tuning &from, const control::Tuning &to, double share) {
    control::Tuning tuning = to;
    for (const control::Parameter &parameter : control::kParameters) {
        const double start = from.*parameter.value;
        tuning.*parameter.value = start + share * (to.*parameter.value - start);
    }
    return tuning;
}

/// Changes end where K_P and K_D could grow by this factor: at the limit itself nothing decays.
constexpr double kLockMargin = 1.02;

control::Tuning with_more_gain(control::Tuning tuning) {
    tuning.K_P_V_per_rad *= kLockMargin;
    tuning.K_D_Vs_per_rad *= kLockMargin;
    return tuning;
}

} // namespace

double StabilityIndicator::time_constant_s() const {
    return period_s / std::abs(std::log(worst.eigenvalue));
}

loops::StabilityCase stability_case_of(const session::Session &session,
                                       const control::Tuning &tuning) {
    loops::StabilityCase which;
    which.device = session.description();
    which.tuning = tuning;
    which.period_s = session.servo().period_s();
    which.delay_periods = session.device().device().delay_periods();
    which.q_rad = device::joint_from_motor(which.device.geometry, session.latest().theta_rad);
    return which;
}

StabilityIndicator TuningEditor::indicator_of(const control::Tuning &tuning) const {
    loops::StabilityCase which = stability_case_of(session_, tuning);
    which.hands = hands_of(hand);
    return {loops::worst_member(which), which.period_s};
}

void TuningEditor::update() { indicator_ = indicator_of(now()); }

bool TuningEditor::exceeds_gain_margin(const control::Tuning &tuning) const {
    return !indicator_of(with_more_gain(tuning)).is_stable();
}

bool TuningEditor::is_refused(const control::Tuning &to) const {
    if (is_unlocked || to == now() || !exceeds_gain_margin(to)) {
        return false;
    }
    // From behind the lock, what is no worse may be set.
    return !exceeds_gain_margin(now()) ||
           indicator_of(to).worst.eigenvalue > indicator_of(now()).worst.eigenvalue;
}

void TuningEditor::drag(const control::Tuning &to, std::uint32_t source) {
    error_.clear();
    control::Tuning reached = to;
    if (is_refused(to)) {
        constexpr int kHalvings = 14;
        const control::Tuning from = now();
        const auto may_go = [&](double share) {
            return !exceeds_gain_margin(on_the_way(from, to, share));
        };
        // The beginning has the map and the source of α of the end.
        reached = may_go(0.0) ? on_the_way(from, to, bisect({0.0, 1.0}, kHalvings, may_go).holds_at)
                              : from;
        const StabilityIndicator beyond = indicator_of(with_more_gain(to));
        error_ = fmt::format("held at the limit: beyond it motor {}, {}, is unstable",
                             beyond.worst.member.motor + 1,
                             loops::hand_text(beyond.worst.member.hand.name));
    }
    history().change(reached, session_.plot_time_s(), source);
    update();
}

void TuningEditor::replace(const control::Tuning &to, const std::string &what) {
    history().let_go();
    if (may_go_to(to, what.c_str())) {
        history().replace(to, session_.plot_time_s(), what);
        update();
    }
}

bool TuningEditor::may_go_to(const control::Tuning &to, const char *what) {
    error_.clear();
    if (!control::is_valid(to)) {
        error_ = std::string(what) + ": not done, as it has values out of their ranges";
        return false;
    }
    if (is_refused(to)) {
        error_ = std::string(what) + ": not done, as that tuning is predicted to be unstable "
                                     "now; unlock first";
        return false;
    }
    return true;
}

void TuningEditor::undo() {
    history().let_go();
    if (history().can_undo() &&
        may_go_to(history().steps()[history().done() - 1].before.now(), "undo")) {
        history().undo(session_.plot_time_s());
        update();
    }
}

void TuningEditor::redo() {
    history().let_go();
    if (history().can_redo() &&
        may_go_to(history().steps()[history().done()].after.now(), "redo")) {
        history().redo(session_.plot_time_s());
        update();
    }
}

void TuningEditor::toggle_slot() {
    history().let_go();
    if (may_go_to(history().slots().other(), "the other slot")) {
        history().toggle(session_.plot_time_s());
        update();
    }
}

void TuningEditor::toggle_map() {
    control::Tuning other = now();
    other.map = other.map == control::MotionMap::transpose ? control::MotionMap::inverse
                                                           : control::MotionMap::transpose;
    replace(other, "map " + std::string(control::label_of(other.map)));
}

} // namespace springdrive::app
