#include "engine/lab/limits/drive_comparison.h"

#include "base/input_error.h"
#include "base/parallel.h"
#include "engine/control/rendered_force.h"
#include "engine/lab/loops/tip_stiffness.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <mutex>
#include <numbers>
#include <ostream>
#include <utility>

namespace springdrive::limits {

namespace {

/// Here K_P is limited by stability only, not by the range of tuning files and panels.
constexpr double kNoBound_V_per_rad = 1000.0;

double stiffness_at(const loops::StabilityCase &which, double frequency_hz) {
    return std::abs(
        loops::tip_stiffness(which, Vector3::UnitY(), 2.0 * std::numbers::pi * frequency_hz));
}

/// A property of a drive.
struct Quality {
    const char *name; ///< with its unit
    const char *label;
    double in_table; ///< factor of the value in the table
    bool more_is_better;
    double (*measured)(const loops::StabilityCase &which);
};

constexpr std::array<Quality, 7> kQualities{{
    {"K_DC_N_per_m", "K_DC", 1e-3, true, // static
     [](const loops::StabilityCase &which) {
         return loops::tip_stiffness(which, Vector3::UnitY(), 0.0).real();
     }},
    {"K_30Hz_N_per_m", "at 30 Hz", 1e-3, true, // the limit of kinaesthetic perception
     [](const loops::StabilityCase &which) { return stiffness_at(which, control::kPerceived_Hz); }},
    {"K_300Hz_N_per_m", "at 300 Hz", 1e-3, true, // where vibration is perceived best
     [](const loops::StabilityCase &which) { return stiffness_at(which, 300.0); }},
    {"K_HF_N_per_m", "K_HF", 1e-3, true, // as the frequency goes to infinity: (14), or 0
     [](const loops::StabilityCase &which) {
         return loops::inductive_tip_stiffness(which, Vector3::UnitY());
     }},
    {"rate_hardness_N_per_m", "rate-hardness", 1e-3, true,
     [](const loops::StabilityCase &which) { return impact(which).rate_hardness_N_per_m; }},
    {"apparent_mass_kg", "mass", 1e3, false, apparent_mass_kg},
    {"count_N", "count", 1.0, false, loops::force_of_a_count_N},
}};

/// By which drives are equally quiet.
constexpr std::size_t kCount = kQualities.size() - 1;
static_assert(kQualities[kCount].measured == loops::force_of_a_count_N);

DriveQualities qualities(loops::StabilityCase which) {
    which.hands = {loops::hand_of_firmness(0.5)};
    DriveQualities all;
    for (const Quality &quality : kQualities) {
        all.push_back(quality.measured(which));
    }
    return all;
}

/// One drive of a comparison.
struct Drive {
    const char *name;
    DriveQualities DriveComparison::*qualities;
    TunedWall DriveComparison::*wall; ///< null for the spring drive
};

constexpr std::array<Drive, 3> kDrives{{
    {"spring", &DriveComparison::spring, nullptr},
    {"current", &DriveComparison::current, &DriveComparison::wall},
    {"current, as quiet", &DriveComparison::quiet_current, &DriveComparison::quiet_wall},
}};

bool beats_spring(const DriveComparison &all, const Drive &drive, std::size_t quality) {
    if (drive.wall == nullptr || all.spring.empty()) {
        return drive.wall != nullptr;
    }
    const double spring = all.spring[quality];
    const double other = (all.*drive.qualities)[quality];
    return kQualities[quality].more_is_better ? other > spring : other < spring;
}

/// Adds a row for each drive with a result. Where no spring drive is stable, there is no current
/// drive as quiet as it either.
/// @param add  receives the row, the comparison, the drive and its qualities
template <typename Add>
void add_rows(Table &table, const std::vector<DriveComparison> &all, const Add &add) {
    for (const DriveComparison &one : all) {
        for (const Drive &drive : kDrives) {
            const DriveQualities &found = one.*drive.qualities;
            if (!found.empty()) {
                add(table.rows.emplace_back(), one, drive, found);
            }
        }
    }
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
        both.spring = qualities(spring);
    } catch (const InputError &) { // no tuning is stable: a valid result
    }
    here.drive = device::AmplifierKind::current_drive;
    here.tuning.eta = 0.0;
    const auto walled = [&](const TunedWall &tuned) {
        loops::StabilityCase current = here;
        current.wall = tuned.wall;
        current.tuning.lambda_rad_per_s = tuned.lambda_rad_per_s;
        return qualities(current);
    };
    both.wall = tuned_wall(here, margin);
    both.current = walled(both.wall);
    if (!both.spring.empty()) {
        both.quiet_wall = tuned_wall(here, margin, both.spring[kCount]);
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

Table comparison_table(const std::vector<DriveComparison> &all) {
    Table table = Table::with_columns("servo_hz,delay_periods,dR_Ohm,drive,K_P_V_per_rad,"
                                      "K_D_Vs_per_rad,wall_K_N_per_m,wall_B_Ns_per_m,"
                                      "lambda_rad_per_s");
    for (const Quality &quality : kQualities) {
        table.columns.push_back({quality.name});
    }
    add_rows(
        table, all,
        [](std::vector<Cell> &row, const DriveComparison &one, const Drive &drive,
           const DriveQualities &found) {
            row = {one.setting.servo_hz, one.setting.delay_periods, one.setting.dR_Ohm, drive.name};
            if (drive.wall == nullptr) {
                row.insert(row.end(), {one.tuning.K_P_V_per_rad, one.tuning.K_D_Vs_per_rad, Cell(),
                                       Cell(), one.tuning.lambda_rad_per_s});
            } else {
                const TunedWall &tuned = one.*drive.wall;
                row.insert(row.end(), {Cell(), Cell(), tuned.wall.stiffness_N_per_m,
                                       tuned.wall.damping_Ns_per_m, tuned.lambda_rad_per_s});
            }
            row.insert(row.end(), found.begin(), found.end());
        });
    return table;
}

void write_comparison_table(std::ostream &out, const std::vector<DriveComparison> &all) {
    out << "Along the vertical: stiffness and rate-hardness in N/mm, mass in free space in g, the "
           "force of one\nencoder count in N. \"As quiet\": one count changes its force no more "
           "than the spring drive's.\nA + marks where a current drive is better than the spring "
           "drive.\nSearched: K_P up to 1000 V/rad, more than tuning files allow, K_D up to 1 "
           "V·s/rad, λ up to 5000 rad/s,\nK up to 1e6 N/m, B from 0.1 to 300 N·s/m. The motors' "
           "peak current limits rate-hardness.\n\n";
    Table table = Table::with_columns("servo,drive");
    for (const Quality &quality : kQualities) {
        table.columns.push_back({quality.label});
    }
    add_rows(table, all,
             [](std::vector<Cell> &row, const DriveComparison &one, const Drive &drive,
                const DriveQualities &found) {
                 row = {fmt::format("{:.5g} Hz, d {:g}, dR {:.3g} Ω", one.setting.servo_hz,
                                    one.setting.delay_periods, one.setting.dR_Ohm),
                        drive.name};
                 for (std::size_t i = 0; i < kQualities.size(); ++i) {
                     row.push_back(Cell::like_number(
                         fmt::format("{:.3g}{}", kQualities[i].in_table * found[i],
                                     beats_spring(one, drive, i) ? " +" : "")));
                 }
             });
    write_markdown(out, table);
    out << "\nHow often the spring drive is the better one:\n";
    Table wins{.columns = {{""}, {kDrives[1].name}, {kDrives[2].name}}};
    for (std::size_t i = 0; i < kQualities.size(); ++i) {
        std::vector<Cell> row{kQualities[i].label};
        for (const Drive &drive : {kDrives[1], kDrives[2]}) {
            const auto better = std::ranges::count_if(all, [&](const DriveComparison &one) {
                return !one.spring.empty() && !beats_spring(one, drive, i);
            });
            row.push_back(Cell::like_number(fmt::format("{} of {}", better, all.size())));
        }
        wins.rows.push_back(std::move(row));
    }
    write_text(out, wins);
}

} // namespace springdrive::limits
