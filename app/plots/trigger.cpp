#include "app/plots/trigger.h"

#include "base/assertions.h"

#include <cmath>
#include <utility>

namespace springdrive::signals {

EdgeDetector::EdgeDetector(const TriggerCondition &condition) : condition_(condition) {
    SPRINGDRIVE_ASSERT(condition.hysteresis >= 0.0);
}

bool EdgeDetector::take(double value) noexcept {
    if (std::isnan(value)) {
        return false;
    }
    switch (condition_.edge) {
    case TriggerEdge::rising:
        return rises(value);
    case TriggerEdge::falling:
        return falls(value);
    case TriggerEdge::either: {
        const bool rose = rises(value);
        return falls(value) || rose; // each value may also arm the other one
    }
    case TriggerEdge::change:
        return changes(value);
    }
    return false;
}

void EdgeDetector::reset() noexcept { *this = EdgeDetector(condition_); }

bool EdgeDetector::rises(double value) noexcept {
    armed_to_rise_ = armed_to_rise_ || value <= condition_.level - condition_.hysteresis;
    return value > condition_.level && std::exchange(armed_to_rise_, false);
}

bool EdgeDetector::falls(double value) noexcept {
    armed_to_fall_ = armed_to_fall_ || value > condition_.level + condition_.hysteresis;
    return value <= condition_.level && std::exchange(armed_to_fall_, false);
}

bool EdgeDetector::changes(double value) noexcept {
    const double before = std::exchange(last_, value);
    return !std::isnan(before) && value != before;
}

Trigger::Trigger(const TriggerSettings &settings) : settings_(settings) {
    SPRINGDRIVE_ASSERT(settings.pre_s >= 0.0);
    SPRINGDRIVE_ASSERT(settings.post_s >= 0.0);
    SPRINGDRIVE_ASSERT(settings.holdoff_s >= 0.0);
}

void Trigger::take(double time_s, bool fired) noexcept {
    if (state_ == TriggerState::waiting && fired && time_s >= held_off_until_s_) {
        state_ = TriggerState::collecting;
        event_s_ = time_s;
        held_off_until_s_ = time_s + settings_.holdoff_s;
    }
    if (state_ == TriggerState::collecting && time_s >= end_s()) {
        state_ = TriggerState::complete;
    }
}

void Trigger::arm() noexcept { *this = Trigger(settings_); }

void Trigger::proceed() noexcept {
    if (state_ == TriggerState::complete && settings_.mode == TriggerMode::repeating) {
        state_ = TriggerState::waiting;
    }
}

std::optional<TimeWindow> Trigger::window() const noexcept {
    if (state_ != TriggerState::complete) {
        return std::nullopt;
    }
    return TimeWindow{event_s_ - settings_.pre_s, end_s()};
}

} // namespace springdrive::signals
