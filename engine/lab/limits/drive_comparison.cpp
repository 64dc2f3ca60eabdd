#include "engine/lab/limits/drive_comparison.h"

#include "base/input_error.h"
#include "base/parallel.h"
#include "engine/control/perception.h"
#include "engine/lab/limits/impact.h"
#include "engine/lab/loops/tip_stiffness.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <numbers>

namespace springdrive::limits {

namespace {

/// Here K_P is limited by stability only, not by the range of tuning files and panels.
constexpr double kNoBound_V_per_rad = 1000.0;

double stiffness_at(const loops::StabilityCase &which, double frequency_hz) {
    return std::abs(
        loops::tip_stiffness(which, Vector3::UnitY(), 2.0 * std::numbers::pi * frequency_hz));
}

DriveQuality quality(loops::StabilityCase which) {
    which.hands = {loops::hand_of_firmness(0.5)};
    DriveQuality found;
    found.K_DC_N_per_m = loops::tip_stiffness(which, Vector3::UnitY(), 0.0).real();
    found.K_30_N_per_m = stiffness_at(which, control::kPerceived_Hz);
    found.K_300_N_per_m = stiffness_at(which, 300.0);
    found.K_HF_N_per_m = loops::inductive_tip_stiffness(which, Vector3::UnitY());
    found.rate_hardness_N_per_m = impact(which).rate_hardness_N_per_m;
    found.apparent_mass_kg = apparent_mass_kg(which);
    found.count_N = loops::force_of_a_count_N(which);
    return found;
}

} // namespace

DriveComparison compare_drives(const loops::StabilityCase &which, double margin,
                               const ServoSetting &setting) {
    DriveComparison both;
    both.setting = setting;
    loops::StabilityCase here = which;
    here.period_s = 1.0 / setting.servo_hz;
    here.delay_periods = setting.delay_periods;
    here.tuning.dR_Ohm = setting.dR_Ohm;

    loops::StabilityCase spring = here;
    spring.drive = device::AmplifierKind::spring_drive;
    try {
        both.tuning = spring.tuning = auto_tune({spring, margin, kNoBound_V_per_rad}).tuning;
        both.spring = quality(spring);
    } catch (const InputError &) { // no tuning is stable: a valid result
        both.spring_is_stable = false;
    }
    here.drive = device::AmplifierKind::current_drive;
    here.tuning.eta = 0.0;
    const auto walled = [&](const TunedWall &tuned) {
        loops::StabilityCase current = here;
        current.wall = tuned.wall;
        current.tuning.lambda_rad_per_s = tuned.lambda_rad_per_s;
        return quality(current);
    };
    both.wall = tuned_wall(here, margin);
    both.current = walled(both.wall);
    if (both.spring_is_stable) {
        both.quiet_wall = tuned_wall(here, margin, both.spring.count_N);
        both.quiet_current = walled(both.quiet_wall);
    }
    return both;
}

std::vector<DriveComparison> compare_drives(const loops::StabilityCase &which, double margin,
                                            const std::vector<ServoSetting> &settings,
                                            const std::function<void(double)> &progress) {
    std::vector<DriveComparison> all(settings.size());
    std::mutex progress_mutex;
    std::size_t done = 0;
    for_each_in_parallel(all.size(), all_processors(), [&](std::size_t i) {
        all[i] = compare_drives(which, margin, settings[i]);
        const std::lock_guard lock(progress_mutex);
        progress(static_cast<double>(++done) / static_cast<double>(all.size()));
    });
    return all;
}

std::vector<ServoSetting> usual_settings() {
    std::vector<ServoSetting> settings;
    for (const double servo_hz : {250.0, 1000.0, 4000.0, 10000.0}) {
        for (const double delay_periods : {0.0, 1.0}) {
            for (const double dR_Ohm : {0.2, 0.5}) {
                settings.push_back({servo_hz, delay_periods, dR_Ohm});
            }
        }
    }
    return settings;
}

} // namespace springdrive::limits
