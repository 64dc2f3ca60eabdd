// Random conditions of a fault: when, where and with which hand, from a seed.
//
// Runs one fault through a servo on a simulated device, and compares its behaviour with an
// independent reference (fault_judge.h).
//
//   rest ── starting ── running ──► fault ──► trip ──► braking ──► reset ──► trip again
//           hand moves or presses                          └─ repaired ─► reset ──► rest ──►
//           starting
//
// Checked in every tick: samples are contiguous; the device's command is that of the last sample; a
// trip has a cause that the reference detects, and no cause with precedence is skipped; what must
// trip does so in time; and the true tip force is not above its limit twice in a row, except for
// the response of shorted windings to the hand.
#pragma once

#include "device/simulated/simulation_options.h"
#include "engine/control/tuning.h"
#include "engine/lab/rig/servo_rig.h"
#include "tests/support/fault_judge.h"

#include <cstdint>
#include <deque>
#include <functional>
#include <random>
#include <string>
#include <utility>

namespace springdrive::testing {

/// Number of faults per cause of a trip; tests record it in their property "faults".
inline constexpr int kFaultsOfACause = 78;
static_assert(13 * kFaultsOfACause > 1000);

inline const device::HandParameters kLightHand{0.03, 1.0, 100.0, 3.0};
inline const device::HandParameters kFirmHand{0.3, 30.0, 1500.0, 20.0};

/// Position of the hand when the fault occurs.
enum class Place : std::uint8_t { anywhere, free, plate, running_free, running_on_plate };

struct FaultCase {
    std::string tuning_name;
    control::Tuning tuning;
    double servo_hz = 1000.0;
    bool firm = false;
    bool on_plate = false;
    Vector3 start_m{Vector3::Zero()};  ///< where it rests initially
    Vector3 target_m{Vector3::Zero()}; ///< where the hand then moves
    double hand_m_per_s = 0.2;
    std::uint64_t at_tick = 0;

    [[nodiscard]] device::HandParameters hand() const;
    [[nodiscard]] std::string description() const;
};

/// Tunings, rates and hands cycle with the number of the case; all else is random.
[[nodiscard]] FaultCase random_case(std::mt19937 &random, int number, Place place);

[[nodiscard]] double uniform(std::mt19937 &random, double minimum, double maximum);
[[nodiscard]] double log_uniform(std::mt19937 &random, double minimum, double maximum);

/// Which hand holds the tip: that of the case, or that of the simulation's options.
enum class HandOf : std::uint8_t { fault_case, options };

class FaultTrial : public rig::ServoRig {
public:
    explicit FaultTrial(const FaultCase &what, const simulated::SimulationOptions &options = {},
                        HandOf hand = HandOf::fault_case);

    /// Runs and checks a tick; hand and window behave as the case specifies.
    servo::ServoSample step();
    /// Runs up to the tick before the fault. Nothing may trip.
    void run_to_fault();
    /// Runs until it trips, at most for `at_most_s`.
    void run_to_trip(double at_most_s);
    void expect_tripped_by(servo::TripCause cause) const;
    /// Expects braking to continue, whether the fault is gone or not.
    void expect_latched();
    /// Expects that a reset trips again while the fault persists. TripCause::none stands for any
    /// cause.
    void expect_reset_trips_again(servo::TripCause cause, double within_s);
    /// For faults that show only with voltage on, or voided the zero: expects no start after a
    /// reset, since the tip touches, or nobody zeroed the device.
    void expect_reset_waits();
    /// Expects a start after a reset once the fault is gone: when the tip rests in free space, not
    /// before; and none if the fault voided the zero.
    void expect_recovery();
    void reset();

    /// Applies a fault from the next period on.
    void commit(device::FaultKind kind, const Vector3 &size) {
        device().commit({kind, size});
        may_contradict_ = true;
    }

    /// Ticks from the first that must trip to the trip; the command takes effect in the next.
    [[nodiscard]] int max_ticks_late() const { return max_ticks_late_; }
    [[nodiscard]] double max_force_N() const { return max_force_N_; }
    [[nodiscard]] int ticks_in(double time_s) const;

    FaultCase what;
    FaultJudge judge;
    std::function<servo::TickTiming()> timing; ///< empty: never late
    bool window_responds = true;
    bool force_is_bounded = true; ///< false if the fault makes the force unbounded

private:
    void check(const device::Measurement &measured);
    void check_trip() const;
    void check_force();
    void check_braking() const;
    void check_rest() const;

    contact::HapticSurface plate_;
    bool may_contradict_ = false; ///< a motor's current and its encoder
    std::uint64_t ticks_ = 0;
    std::uint64_t since_reset_ = 0;
    int late_ = 0;
    int max_ticks_late_ = 0;
    int above_force_ = 0; ///< consecutive ticks
    double force_N_ = 0.0;
    double brake_N_ = 0.0; ///< of shorted windings at the hand's speed
    double max_force_N_ = 0.0;
    std::deque<std::pair<Vector3, bool>> recent_; ///< tip, and whether it touched
};

} // namespace springdrive::testing
