#include "app/study/sitting/device_stops.h"

#include "device/core/board_faults.h"
#include "engine/servo/safety_status.h"

#include <cstdint>
#include <utility>

namespace springdrive::app::study_screen {

namespace {

constexpr double kCalm_s = 3.0;   ///< after which a stop by the monitor is over
constexpr double kOldest_s = 0.2; ///< of what is known of the device

/// The emergency stop, or the board's switch.
bool is_wanted(const servo::SafetyStatus &safety) {
    const auto bits = static_cast<std::uint16_t>(safety.measured);
    return safety.cause == servo::TripCause::emergency_stop ||
           (safety.cause == servo::TripCause::board_fault &&
            device::BoardFaults{bits}.has(device::BoardFaults::kStop));
}

} // namespace

DeviceStops::DeviceStops(session::Session &session, std::function<void(const std::string &)> note)
    : session_(session), note_(std::move(note)) {}

void DeviceStops::watch(bool emergency_stop) {
    const servo::SafetyStatus &safety = session_.latest().safety;
    const bool is_tripped = safety.state == servo::SafetyState::tripped;
    const bool was_tripped = std::exchange(was_tripped_, is_tripped);
    const bool is_new = is_tripped && !was_tripped;
    // What is known of the device may be older than its reset.
    const bool is_recent = is_new || session_.servo().now_s() > reset_s_ + kOldest_s;
    is_by_hand_ = is_by_hand_ || emergency_stop || (is_tripped && is_recent && is_wanted(safety));
    if (emergency_stop || is_new) {
        may_go_on_ = false; // it was of another
        begin_calm();
    }
    if (is_new && is_in_trial_) {
        of_trial_ = servo::description(safety);
    } else if (is_new && !std::exchange(is_known_, false)) {
        ++count_;
        note_(servo::description(safety));
    } else if (emergency_stop && was_tripped) {
        note_("the emergency stop was pressed while the device was stopped");
    }
}

void DeviceStops::begin_trial() {
    is_in_trial_ = true;
    is_known_ = false;
    of_trial_.reset();
}

void DeviceStops::end_trial(bool is_stored) {
    is_in_trial_ = false;
    is_known_ = is_stored && !of_trial_;
    if (is_stored || of_trial_) {
        ++count_;
    }
    if (!is_stored && of_trial_) {
        note_(*of_trial_);
    }
}

void DeviceStops::begin_calm() { calm_from_s_ = session_.servo().now_s(); }

void DeviceStops::reset_when_allowed() {
    const double now_s = session_.servo().now_s();
    if (std::exchange(may_go_on_, false) || (!is_by_hand_ && now_s > calm_from_s_ + kCalm_s)) {
        session_.servo().reset_safety();
        is_by_hand_ = false;
        calm_from_s_ = reset_s_ = now_s;
    }
}

} // namespace springdrive::app::study_screen
