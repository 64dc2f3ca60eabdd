// The outputs of drive_comparison.h.
#include "engine/lab/limits/drive_comparison.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <ostream>
#include <string>

namespace springdrive::limits {

namespace {

struct Quality {
    const char *name;
    const char *label;
    double DriveQuality::*value;
    double in_table; ///< factor of the value in the table
    bool more_is_better;
};

constexpr std::array<Quality, 7> kQualities{{
    {"K_DC_N_per_m", "K_DC", &DriveQuality::K_DC_N_per_m, 1e-3, true},
    {"K_30Hz_N_per_m", "at 30 Hz", &DriveQuality::K_30_N_per_m, 1e-3, true},
    {"K_300Hz_N_per_m", "at 300 Hz", &DriveQuality::K_300_N_per_m, 1e-3, true},
    {"K_HF_N_per_m", "K_HF", &DriveQuality::K_HF_N_per_m, 1e-3, true},
    {"rate_hardness_N_per_m", "rate-hardness", &DriveQuality::rate_hardness_N_per_m, 1e-3, true},
    {"apparent_mass_kg", "mass", &DriveQuality::apparent_mass_kg, 1e3, false},
    {"count_N", "count", &DriveQuality::count_N, 1.0, false},
}};

/// One drive of a comparison.
struct Drive {
    const char *name;
    DriveQuality DriveComparison::*quality;
    TunedWall DriveComparison::*wall; ///< null for the spring drive
};

constexpr std::array<Drive, 3> kDrives{{
    {"spring", &DriveComparison::spring, nullptr},
    {"current", &DriveComparison::current, &DriveComparison::wall},
    {"current, as quiet", &DriveComparison::quiet_current, &DriveComparison::quiet_wall},
}};

/// Whether there are results for a drive: where no spring drive is stable, there is no current
/// drive as quiet as it either.
bool is_there(const DriveComparison &all, const Drive &drive) {
    return all.spring_is_stable || drive.quality == &DriveComparison::current;
}

bool beats_spring(const DriveComparison &all, const Drive &drive, const Quality &quality) {
    const double spring = all.spring.*quality.value;
    const double other = (all.*drive.quality).*quality.value;
    return drive.wall != nullptr &&
           (!all.spring_is_stable || (quality.more_is_better ? other > spring : other < spring));
}

} // namespace

Table comparison_table(const std::vector<DriveComparison> &all) {
    Table table = Table::with_columns("servo_hz,delay_periods,dR_Ohm,drive,K_P_V_per_rad,"
                                      "K_D_Vs_per_rad,wall_K_N_per_m,wall_B_Ns_per_m,"
                                      "lambda_rad_per_s");
    for (const Quality &quality : kQualities) {
        table.columns.push_back({quality.name});
    }
    for (const DriveComparison &one : all) {
        for (const Drive &drive : kDrives) {
            if (!is_there(one, drive)) {
                continue;
            }
            std::vector<Cell> row{one.setting.servo_hz, one.setting.delay_periods,
                                  one.setting.dR_Ohm, drive.name};
            if (drive.wall == nullptr) {
                row.insert(row.end(), {one.tuning.K_P_V_per_rad, one.tuning.K_D_Vs_per_rad, Cell(),
                                       Cell(), one.tuning.lambda_rad_per_s});
            } else {
                const TunedWall &tuned = one.*drive.wall;
                row.insert(row.end(), {Cell(), Cell(), tuned.wall.stiffness_N_per_m,
                                       tuned.wall.damping_Ns_per_m, tuned.lambda_rad_per_s});
            }
            for (const Quality &quality : kQualities) {
                row.emplace_back((one.*drive.quality).*quality.value);
            }
            table.rows.push_back(std::move(row));
        }
    }
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
    for (const DriveComparison &one : all) {
        for (const Drive &drive : kDrives) {
            if (!is_there(one, drive)) {
                continue;
            }
            std::vector<Cell> row{fmt::format("{:.5g} Hz, d {:g}, dR {:.3g} Ω",
                                              one.setting.servo_hz, one.setting.delay_periods,
                                              one.setting.dR_Ohm),
                                  drive.name};
            for (const Quality &quality : kQualities) {
                row.push_back(Cell::like_number(fmt::format(
                    "{:.3g}{}", quality.in_table * ((one.*drive.quality).*quality.value),
                    beats_spring(one, drive, quality) ? " +" : "")));
            }
            table.rows.push_back(std::move(row));
        }
    }
    write_markdown(out, table);
    out << "\nHow often the spring drive is the better one:\n";
    Table wins{.columns = {{""}, {kDrives[1].name}, {kDrives[2].name}}};
    for (const Quality &quality : kQualities) {
        std::vector<Cell> row{quality.label};
        for (const Drive &drive : {kDrives[1], kDrives[2]}) {
            const auto better = std::ranges::count_if(all, [&](const DriveComparison &one) {
                return one.spring_is_stable && !beats_spring(one, drive, quality);
            });
            row.push_back(Cell::like_number(fmt::format("{} of {}", better, all.size())));
        }
        wins.rows.push_back(std::move(row));
    }
    write_text(out, wins);
}

} // namespace springdrive::limits
