// The outputs of drive_comparison.h.
#include "base/print.h"
#include "engine/lab/limits/drive_comparison.h"

#include <array>
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

void write_gains(std::ostream &out, const DriveComparison &all, const Drive &drive) {
    if (drive.wall == nullptr) {
        print(out, ",{},{},,,{}", all.tuning.K_P_V_per_rad, all.tuning.K_D_Vs_per_rad,
              all.tuning.lambda_rad_per_s);
        return;
    }
    const TunedWall &tuned = all.*drive.wall;
    print(out, ",,,{},{},{}", tuned.wall.stiffness_N_per_m, tuned.wall.damping_Ns_per_m,
          tuned.lambda_rad_per_s);
}

} // namespace

void write_comparison_csv(std::ostream &out, const std::vector<DriveComparison> &all) {
    out << "servo_hz,delay_periods,dR_Ohm,drive,K_P_V_per_rad,K_D_Vs_per_rad,wall_K_N_per_m,"
           "wall_B_Ns_per_m,lambda_rad_per_s";
    for (const Quality &quality : kQualities) {
        out << ',' << quality.name;
    }
    out << '\n';
    for (const DriveComparison &one : all) {
        for (const Drive &drive : kDrives) {
            if (!is_there(one, drive)) {
                continue;
            }
            print(out, "{},{},{},\"{}\"", one.setting.servo_hz, one.setting.delay_periods,
                  one.setting.dR_Ohm, drive.name);
            write_gains(out, one, drive);
            for (const Quality &quality : kQualities) {
                print(out, ",{}", (one.*drive.quality).*quality.value);
            }
            out << '\n';
        }
    }
}

void write_comparison_table(std::ostream &out, const std::vector<DriveComparison> &all) {
    out << "Along the vertical: stiffness and rate-hardness in N/mm, mass in free space in g, the "
           "force of one\nencoder count in N. \"As quiet\": one count changes its force no more "
           "than the spring drive's.\nA + marks where a current drive is better than the spring "
           "drive.\nSearched: K_P up to 1000 V/rad, more than tuning files allow, K_D up to 1 "
           "V·s/rad, λ up to 5000 rad/s,\nK up to 1e6 N/m, B from 0.1 to 300 N·s/m. The motors' "
           "peak current limits rate-hardness.\n\n"
           "| servo | drive ";
    for (const Quality &quality : kQualities) {
        print(out, "| {} ", quality.label);
    }
    out << "|\n| --- | --- ";
    for (std::size_t i = 0; i < kQualities.size(); ++i) {
        out << "| ---: ";
    }
    out << "|\n";
    for (const DriveComparison &one : all) {
        for (const Drive &drive : kDrives) {
            if (!is_there(one, drive)) {
                continue;
            }
            print(out, "| {:.5g} Hz, d {:g}, dR {:.3g} Ω | {} ", one.setting.servo_hz,
                  one.setting.delay_periods, one.setting.dR_Ohm, drive.name);
            for (const Quality &quality : kQualities) {
                print(out, "| {:.3g}{} ", quality.in_table * ((one.*drive.quality).*quality.value),
                      beats_spring(one, drive, quality) ? " +" : "");
            }
            out << "|\n";
        }
    }
    out << "\nHow often the spring drive is the better one:\n";
    for (const Quality &quality : kQualities) {
        print(out, "  {:<14}", quality.label);
        for (const Drive &drive : {kDrives[1], kDrives[2]}) {
            std::size_t better = 0;
            for (const DriveComparison &one : all) {
                better += one.spring_is_stable && !beats_spring(one, drive, quality) ? 1 : 0;
            }
            print(out, "  {} of {} ({})", better, all.size(), drive.name);
        }
        out << '\n';
    }
}

} // namespace springdrive::limits
