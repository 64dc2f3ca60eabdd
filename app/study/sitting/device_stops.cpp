#include "app/study/sitting/device_stops.h"

#include "device/core/board_faults.h"
#include "engine/servo/safety_status.h"

#include <cstdint>
#include <utility>

namespace springdrive::app::study_screen {

namespace {

constexpr double kCalm_s = 3.0;   ///< after which a stop by the monitor is over
constexpr double kOldest_s = 0.2; ///< of what is known of the device

/// By the emergency stop, or by the board's switch: now, or as what the monitor saw first.
bool is_wanted(const servo::ServoSample &sample) {
    const servo::SafetyStatus &safety = sample.safety;
    const device::BoardFaults first{safety.cause == servo::TripCause::board_fault
                                        ? static_cast<std::uint16_t>(safety.measured)
                                        : std::uint16_t{0}};
    return safety.cause == servo::TripCause::emergency_stop ||
           first.has(device::BoardFaults::kStop) ||
           device::BoardFaults{sample.board_faults}.has(device::BoardFaults::kStop);
}

} // namespace

DeviceStops::DeviceStops(session::Session &session, std::function<void(const std::string &)> note)
    : session_(session), note_(std::move(note)), presses_(session.servo().inputs().stop_count) {}

void DeviceStops::watch() {
    session_.servo().take_in();
    const servo::ServoSample &latest = session_.latest();
    const std::uint32_t presses = session_.servo().inputs().stop_count;
    const bool is_pressed = presses > std::exchange(presses_, presses);
    const bool is_tripped = latest.safety.state == servo::SafetyState::tripped;
    const bool was_tripped = std::exchange(was_tripped_, is_tripped);
    // What is known of the device may be older than its reset; and it may trip again at once.
    const bool is_recent = session_.servo().now_s() > reset_s_ + kOldest_s;
    const bool is_new = is_tripped && (!was_tripped || (is_reset_ && is_recent));
    is_reset_ = is_reset_ && is_tripped && !is_new;
    const bool is_switched =
        is_tripped && (is_new || is_recent) && is_wanted(latest) && !is_by_hand();
    if (is_switched) {
        session_.servo().emergency_stop(); // the board's switch may be let go of
        presses_ = session_.servo().inputs().stop_count;
    }
    has_news_ = is_pressed || is_switched || is_new;
    if (has_news_) {
        may_go_on_ = false; // it was of another
        begin_calm();
    }
    if (is_new && is_in_trial_) {
        of_trial_ = servo::description(latest.safety);
    } else if (is_new) {
        ++count_;
        note_(servo::description(latest.safety));
    } else if (is_pressed && was_tripped) {
        note_("the emergency stop was pressed while the device was stopped");
    } else if (is_switched) {
        note_("the board's stop switch was pressed while the device was stopped");
    }
}

void DeviceStops::begin_trial() {
    is_in_trial_ = true;
    of_trial_.reset();
}

void DeviceStops::end_trial(bool is_stored) {
    if (is_stored && !of_trial_) { // a course sees a stop before its sample is published
        session_.servo().paused([] {});
    }
    watch();
    is_in_trial_ = false;
    if (is_stored || of_trial_) {
        ++count_;
    }
    if (!is_stored && of_trial_) {
        note_(*of_trial_);
    }
}

bool DeviceStops::is_by_hand() const { return session_.servo().inputs().emergency_stop; }

void DeviceStops::begin_calm() { calm_from_s_ = session_.servo().now_s(); }

void DeviceStops::reset_when_allowed() {
    const double now_s = session_.servo().now_s();
    if (was_tripped_ &&
        (std::exchange(may_go_on_, false) || (!is_by_hand() && now_s > calm_from_s_ + kCalm_s))) {
        session_.servo().reset_safety();
        is_reset_ = true;
        calm_from_s_ = reset_s_ = now_s;
    }
}

} // namespace springdrive::app::study_screen
