// Spring drive against current drive, each with its best stable tuning on the same device, servo,
// delay, encoder and hands: a test of the paper's claim.
#pragma once

#include "base/table.h"
#include "engine/lab/limits/auto_tune.h"
#include "engine/lab/limits/wall_tune.h"

#include <functional>
#include <ostream>
#include <vector>

namespace springdrive::limits {

/// Servo rate, delay and dR of one comparison.
struct ServoSetting {
    double servo_hz = 1000.0;
    double delay_periods = 0.0;
    double dR_Ohm = 0.5;

    bool operator==(const ServoSetting &) const = default;
};

/// Properties of one drive along the vertical at the case's configuration.
struct DriveQuality {
    double K_DC_N_per_m = 0.0;          ///< static, along the normal
    double K_30_N_per_m = 0.0;          ///< |stiffness| at 30 Hz, the limit of kinaesthetic
                                        ///< perception
    double K_300_N_per_m = 0.0;         ///< at 300 Hz, where vibration is perceived best
    double K_HF_N_per_m = 0.0;          ///< as the frequency goes to infinity: (14), or 0
    double rate_hardness_N_per_m = 0.0; ///< see `Impact`
    double apparent_mass_kg = 0.0;      ///< in free space
    double count_N = 0.0; ///< change of the tip's force in a period from one count of one encoder
};

struct DriveComparison {
    ServoSetting setting;
    bool spring_is_stable = true; ///< false: no tuning is, with the requested margin
    control::Tuning tuning;       ///< of the spring drive
    TunedWall wall;               ///< of the current drive
    TunedWall quiet_wall;         ///< of one with no larger count force than the spring drive
    DriveQuality spring;
    DriveQuality current;
    DriveQuality quiet_current;
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
