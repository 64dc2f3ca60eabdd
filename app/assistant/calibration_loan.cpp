#include "app/assistant/calibration_loan.h"

#include "base/complaint.h"
#include "device/simulated/calibration_tour.h"

#include <utility>

namespace springdrive::app::assistant {

namespace {

using commissioning::CalibrationRun;
using commissioning::CalibrationStage;

/// Between two views: twice a frame.
constexpr int kTicksBetweenViews = 8;

/// At the end, for the board to clear the silence that it has latched while it was asked to store.
constexpr int kSettling_ticks = 100;

/// A device whose time waits is not run on for longer without the window, as by a servo; a share of
/// what would stop any other.
constexpr double kWaitingShare = 0.5;

} // namespace

CalibrationLoan::Uncalibrated::Uncalibrated(device::HapticDevice &device)
    : ForwardingDevice(device), description_(device.description()) {
    description_.calibration.reset();
}

CalibrationLoan::CalibrationLoan(session::Session &session, std::shared_ptr<CalibrationTalk> talk)
    : talk_(std::move(talk)),
      hand_(session.device().emulated() != nullptr ? session.device().hand() : nullptr),
      device_(session.device().device()) {
    run_.emplace(device_);
}

CalibrationLoan::~CalibrationLoan() {
    run_.reset(); // brakes
    let_hand_rest();
}

bool CalibrationLoan::step() {
    if (!run_) {
        return settle();
    }
    if (waits_for_window()) {
        return true;
    }
    run_->note_window(frames_);
    move_hand();
    if (talk_->wants_end_.load(std::memory_order_relaxed)) {
        run_->finish();
    }
    const bool goes_on = run_->step();
    if (!goes_on || ticks_++ % kTicksBetweenViews == 0) {
        show();
    }
    if (!goes_on) {
        end_run();
    }
    return true;
}

bool CalibrationLoan::waits_for_window() {
    const std::uint32_t frames = talk_->frames_.load(std::memory_order_relaxed);
    ticks_without_frame_ = frames == frames_ ? ticks_without_frame_ + 1 : 0;
    frames_ = frames;
    return device_.clock() == device::DeviceClock::servo &&
           ticks_without_frame_ > kWaitingShare * CalibrationRun::kRate_hz *
                                      device_.description().limits.window_silence_s;
}

/// The simulated hand does as a person is asked to.
void CalibrationLoan::move_hand() {
    if (hand_ != nullptr && !hand_moves_ && run_->stage() == CalibrationStage::motion) {
        hand_moves_ = true;
        hand_->follow(simulated::calibration_tour(device_.description(), hand_->hand_m(),
                                                  run_->motion_left_s()));
    }
}

/// Its path may be far from over.
void CalibrationLoan::let_hand_rest() {
    if (std::exchange(hand_moves_, false)) {
        hand_->follow(simulated::HandPath({{0.0, hand_->hand_m()}}));
    }
}

void CalibrationLoan::show() {
    CalibrationView view;
    view.stage = run_->stage();
    view.share = run_->share();
    view.least_known = run_->least_known();
    view.motion_left_s = run_->motion_left_s();
    view.motor = run_->progress();
    view.theta_rad = run_->sample().theta_rad;
    talk_->view_.publish(view);
}

/// The board keeps it, if it is one that can be kept.
void CalibrationLoan::end_run() {
    outcome_.report = run_->report();
    run_.reset(); // brakes
    let_hand_rest();
    if (outcome_.report.is_complete) {
        device::Bench &bench = *device_.bench();
        outcome_.storing_complaint = complaint_of([&] {
            bench.store(outcome_.report.calibration);
            outcome_.kept = bench.stored_calibration();
        });
    }
}

bool CalibrationLoan::settle() {
    const device::Measurement measured = device_.read();
    device::DeviceCommand command = device::DeviceCommand::braking();
    command.number = measured.number;
    // Any other fault is left to the session's servo, which trips by it.
    command.resets_faults =
        reset_.may_follow(measured) && measured.faults.bits == device::BoardFaults::kNoCommand;
    device_.write(command);
    if (++settling_ticks_ < kSettling_ticks) {
        return true;
    }
    talk_->outcome_ = std::move(outcome_);
    return false;
}

} // namespace springdrive::app::assistant
