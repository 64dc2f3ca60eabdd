// Spring drive against current drive, each with its best stable tuning on the same device, servo,
// delay, encoder and hands: a test of the paper's claim.
#pragma once

#include "base/table.h"
#include "engine/lab/limits/auto_tune.h"

#include <cmath>
#include <functional>
#include <ostream>
#include <vector>

namespace springdrive::limits {

/// The stiffest virtual wall that a current drive renders stably: the baseline for the spring
/// drive, tuned with the same care.
struct TunedWall {
    control::VirtualWall wall;
    double lambda_rad_per_s = 0.0; ///< of its velocity filter
};

/// The largest K, over all B and λ, for which every motor alone and all together are stable with
/// every hand, even with K and B larger by `margin`, and for which every motor comes to rest with
/// its counts and supply in trials with every hand. K is zero where nothing is stable.
/// @param which  its drive, wall, λ and freedom are ignored
/// @param max_count_N  maximum change of force from one count, see `force_of_a_count_N`
[[nodiscard]] TunedWall tuned_wall(loops::StabilityCase which, double margin,
                                   double max_count_N = HUGE_VAL);

/// A tip that moves down onto a level wall of the simulated device.
struct Impact {
    /// Rate-hardness after Lawrence et al. 2000: the initial rate of change of the force over the
    /// initial speed of penetration. Here the steepest line from the moment of contact to the force
    /// of the motors along the normal 1 to 10 ms later, over the tip's speed at that moment; the
    /// mean over contact times spread over a servo period [N/m]. The force is read every 20 µs, as
    /// between two ticks it may be larger than at either. The skin does not resolve times below
    /// 1 ms.
    double rate_hardness_N_per_m = 0.0;
    double max_force_N = 0.0; ///< of the motors, within the same time
};

/// @param which of its hands, the first holds the tip
/// @param speed_m_per_s  at which the hand moves down
[[nodiscard]] Impact impact(const loops::StabilityCase &which, double speed_m_per_s = 0.1);

/// The tip's apparent mass in free space while the hand moves it back and forth along the vertical
/// at 5 Hz: the part of the hand's force proportional to acceleration, without the hand's own mass,
/// weight and friction [kg].
[[nodiscard]] double apparent_mass_kg(const loops::StabilityCase &which);

/// Servo rate, delay and dR of one comparison.
struct ServoSetting {
    double servo_hz = 1000.0;
    double delay_periods = 0.0;
    double dR_Ohm = 0.5;

    bool operator==(const ServoSetting &) const = default;
};

/// Properties of one drive along the vertical at the case's configuration, in the order of the
/// columns of `comparison_table`; empty where no such drive is stable.
using DriveQualities = std::vector<double>;

struct DriveComparison {
    ServoSetting setting;
    control::Tuning tuning; ///< of the spring drive
    TunedWall wall;         ///< of the current drive
    TunedWall quiet_wall;   ///< of one with no larger count force than the spring drive
    DriveQualities spring;
    DriveQualities current;
    DriveQualities quiet_current;
};

/// @param which   its device, configuration and hands
/// @param margin  of both drives, see `AutoTuneRequest`
[[nodiscard]] DriveComparison compare_drives(const loops::StabilityCase &which, double margin,
                                             const ServoSetting &setting);

/// All settings, on all processors. @param progress  receives a share from 0 to 1
[[nodiscard]] std::vector<DriveComparison>
compare_drives(const loops::StabilityCase &which, double margin,
               const std::vector<ServoSetting> &settings,
               const std::function<void(double)> &progress);

/// Servo rates from 250 Hz to 10 kHz, without and with a delay, and with a small and a medium dR.
[[nodiscard]] std::vector<ServoSetting> usual_settings();

/// For programs: a row a setting and drive.
[[nodiscard]] Table comparison_table(const std::vector<DriveComparison> &all);

/// The same for people, with marks where the spring drive is not the better one.
void write_comparison_table(std::ostream &out, const std::vector<DriveComparison> &all);

} // namespace springdrive::limits
