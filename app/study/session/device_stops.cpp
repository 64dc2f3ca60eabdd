#include "app/study/session/study_session.h"

#include "device/core/haptic_device.h"
#include "engine/servo/safety_status.h"

#include <utility>

namespace springdrive::app::study_screen {

namespace {

constexpr double kCalm_s = 3.0;   ///< after which a stop that nobody requested is over
constexpr double kOldest_s = 0.2; ///< of what is known of the device

} // namespace

DeviceStops::DeviceStops(session::Session &session, bool resets_itself,
                         std::function<void(const std::string &)> note)
    : session_(session), resets_itself_(resets_itself), note_(std::move(note)) {}

void DeviceStops::watch() {
    session_.servo().take_in();
    const servo::ServoSample &latest = session_.latest();
    const std::uint32_t held_stop = latest.safety.held_stop;
    const bool is_requested = held_stop > std::exchange(held_stop_, held_stop);
    const bool is_tripped = latest.safety.state == servo::SafetyState::tripped;
    const bool was_tripped = std::exchange(was_tripped_, is_tripped);
    // What is known of the device may be older than its reset; and it may trip again at once.
    const bool is_recent = session_.servo().now_s() > reset_s_ + kOldest_s;
    const bool is_new = is_tripped && (!was_tripped || (is_reset_ && is_recent));
    is_reset_ = is_reset_ && is_tripped && !is_new;
    if (is_new || is_requested) {
        begin_calm();
    }
    if (is_new && is_in_trial_) {
        of_trial_ = servo::description(latest.safety);
    } else if (is_new) {
        ++count_;
        note_(servo::description(latest.safety));
    } else if (is_requested && was_tripped) {
        const bool is_switch =
            device::BoardFaults{latest.board_faults}.has(device::BoardFaults::kStop);
        note_(std::string(is_switch ? "the board's stop switch" : "the emergency stop") +
              " was pressed while the device was stopped");
    }
}

void DeviceStops::begin_trial() {
    is_in_trial_ = true;
    of_trial_.reset();
}

void DeviceStops::end_trial(bool is_stored) {
    if (!is_in_trial_) {
        return;
    }
    if (is_stored && !of_trial_) { // a schedule sees a stop before its sample is published
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

void DeviceStops::begin_calm() { calm_from_s_ = session_.servo().now_s(); }

void DeviceStops::note_reset() {
    is_reset_ = was_tripped_;
    calm_from_s_ = reset_s_ = session_.servo().now_s();
}

void DeviceStops::let_go_on() {
    session_.servo().let_go_on();
    if (!session_.servo().is_held_stopped()) { // otherwise it was of an earlier stop
        note_reset();
    }
}

void DeviceStops::reset_when_calm() {
    if (resets_itself_ && was_tripped_ && !session_.servo().is_held_stopped() &&
        session_.servo().now_s() > calm_from_s_ + kCalm_s) {
        session_.servo().reset_safety();
        note_reset();
    }
}

} // namespace springdrive::app::study_screen
