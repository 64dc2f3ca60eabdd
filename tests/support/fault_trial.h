// Runs one fault through a servo on a simulated device, and holds what it does against a judge of
// its own (fault_judge.h).
//
//   rest ── starting ── running ──► fault ──► trip ──► braking ──► reset ──► trip again
//           hand moves or presses                          └─ mended ─► reset ──► rest ──► starting
//
// In every tick, whatever happens: samples are contiguous; what the device hears is what the last
// sample says; a trip has a cause that the judge sees, and no earlier one that must be named before
// it; what must trip does so in time; and the true tip force is not above its limit twice in a row,
// but for what the hand itself does to shorted windings.
#pragma once

#include "engine/lab/rig/servo_rig.h"
#include "tests/support/fault_case.h"
#include "tests/support/fault_judge.h"

#include <cstdint>
#include <deque>
#include <functional>
#include <utility>

namespace springdrive::testing {

/// Whose hand holds the tip: that of the case, or that of the simulation's options.
enum class HandOf : std::uint8_t { fault_case, options };

class FaultTrial : public rig::ServoRig {
public:
    explicit FaultTrial(const FaultCase &what, const simulated::SimulationOptions &options = {},
                        HandOf hand = HandOf::fault_case);

    /// A tick, judged; the hand goes and the window lives as the case says.
    servo::ServoSample step();
    /// Until the tick of the fault is the next. Nothing may trip on the way.
    void run_to_fault();
    /// Until it trips, at most for so long.
    void run_to_trip(double at_most_s);
    void expect_tripped_by(servo::TripCause cause) const;
    /// Brakes on, though nothing is wrong any more or all still is.
    void expect_latched();
    /// A reset does not help while the fault is there. No cause: any will do.
    void expect_reset_trips_again(servo::TripCause cause, double within_s);
    /// Or where the fault shows only with voltage on: it does not start, since the tip touches.
    void expect_reset_waits();
    /// And does when it is gone: after the tip has come to rest in free space, not before.
    void expect_recovery();
    void reset();

    /// From the next period on.
    void commit(rig::FaultKind kind, const Vector3 &size) { device().commit({kind, size}); }

    /// Ticks from the first that must trip to the trip; the command goes out in the next.
    [[nodiscard]] int most_ticks_late() const { return most_ticks_late_; }
    [[nodiscard]] double greatest_force_N() const { return greatest_force_N_; }
    [[nodiscard]] int ticks_in(double time_s) const;

    FaultCase what;
    FaultJudge judge;
    std::function<servo::TickTiming()> timing; ///< none: never late
    bool window_lives = true;
    bool force_is_bounded = true; ///< false where the fault itself leaves no bound

private:
    void check(const device::Measurement &measured);
    void check_trip() const;
    void check_force();
    void check_braking() const;
    void check_rest() const;

    contact::HapticSurface plate_;
    std::uint64_t ticks_ = 0;
    std::uint64_t since_reset_ = 0;
    int late_ = 0;
    int most_ticks_late_ = 0;
    int above_force_ = 0; ///< ticks in a row
    double force_N_ = 0.0;
    double brake_N_ = 0.0; ///< of shorted windings at the hand's speed
    double greatest_force_N_ = 0.0;
    std::deque<std::pair<Vector3, bool>> recent_; ///< tip, and whether it touched
};

} // namespace springdrive::testing
