// A calibration on the thread of a loan, driven by the hand on the device and watched by a window.
// Neither waits for the other:
//
//   window ── note_frame, finish ──► CalibrationTalk ──► CalibrationLoan: run, store, settle
//   window ◄── view, outcome    ◄── CalibrationTalk ◄──┘
#pragma once

#include "base/latest_value.h"
#include "device/core/board_reset.h"
#include "device/core/forwarding_device.h"
#include "engine/commissioning/calibration_run.h"
#include "engine/session/session.h"

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

namespace springdrive::app::assistant {

/// What is seen of it meanwhile.
struct CalibrationView {
    commissioning::CalibrationStage stage = commissioning::CalibrationStage::rest;
    double share = 0.0; ///< of the stage
    std::size_t least_known = 0;
    double motion_left_s = 0.0;
    std::array<commissioning::MotorProgress, 3> motor;
    Vector3 theta_rad{Vector3::Zero()};
};

/// What came of it.
struct CalibrationOutcome {
    commissioning::CalibrationReport report;
    std::optional<device::Calibration> kept; ///< by the board, as it will be read from there
    std::string storing_complaint;           ///< why the board does not keep it
};

class CalibrationTalk {
public:
    // The window's:

    void note_frame() { frames_.fetch_add(1, std::memory_order_relaxed); }
    /// Ends the motion with what has been learned.
    void finish() { wants_end_.store(true, std::memory_order_relaxed); }
    [[nodiscard]] const CalibrationView &view() { return view_.latest(); }
    /// Once the loan is over; empty if it was ended before its end.
    [[nodiscard]] const std::optional<CalibrationOutcome> &outcome() const { return outcome_; }

private:
    friend class CalibrationLoan;

    std::atomic<std::uint32_t> frames_{1};
    std::atomic<bool> wants_end_{false};
    LatestValue<CalibrationView> view_;
    std::optional<CalibrationOutcome> outcome_; ///< written last
};

/// Destroyed before its end, it brakes, and the board keeps what it had.
class CalibrationLoan {
public:
    /// @param session  its device is used by `step` alone
    /// @throw InputError for a device of which nothing can be learned
    CalibrationLoan(session::Session &session, std::shared_ptr<CalibrationTalk> talk);
    ~CalibrationLoan();
    CalibrationLoan(const CalibrationLoan &) = delete;
    CalibrationLoan &operator=(const CalibrationLoan &) = delete;

    /// One tick, CalibrationRun::kRate_hz times a second. @return whether there is more to do
    bool step();

private:
    /// As it would be without a calibration: what was known before is no part of the result.
    class Uncalibrated final : public device::ForwardingDevice {
    public:
        explicit Uncalibrated(device::HapticDevice &device);
        [[nodiscard]] const device::DeviceDescription &description() const override {
            return description_;
        }

    private:
        device::DeviceDescription description_;
    };

    [[nodiscard]] bool waits_for_window();
    void move_hand();
    void let_hand_rest();
    void show();
    void end_run();
    bool settle();

    std::shared_ptr<CalibrationTalk> talk_;
    simulated::HandControl *hand_; ///< of an emulated device; else null
    Uncalibrated device_;
    std::optional<commissioning::CalibrationRun> run_;
    CalibrationOutcome outcome_;
    bool hand_moves_ = false;
    int ticks_ = 0;
    int settling_ticks_ = 0;
    device::BoardReset reset_{false}; ///< in these
    std::uint32_t frames_ = 0;        ///< seen last
    int ticks_without_frame_ = 0;
};

} // namespace springdrive::app::assistant
