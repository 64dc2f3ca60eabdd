// The outputs of thermal_hold.h.
#include "base/degrees.h"
#include "base/print.h"
#include "engine/lab/limits/thermal_hold.h"

#include <algorithm>
#include <cmath>
#include <ostream>
#include <string>

namespace springdrive::limits {

namespace {

/// Enough to show the course of a phase.
constexpr std::size_t kTableRows = 11;

const char *name(ThermalPhase phase) { return phase == ThermalPhase::hold ? "hold" : "cool"; }

/// Calls `visit(name, value)` for every number: the one list behind header and rows.
template <typename Visit> void for_each_column(const ThermalRow &row, Visit &&visit) {
    const auto motors = [&visit](const char *name, const char *unit, const Vector3 &v) {
        for (Eigen::Index j = 0; j < 3; ++j) {
            visit(std::string(name) + std::to_string(j + 1) + "_" + unit, v[j]);
        }
    };
    motors("winding", "C", row.winding_C);
    motors("R_hat_asked", "Ohm", row.R_hat_asked_Ohm);
    motors("R_hat_allowed", "Ohm", row.R_hat_allowed_Ohm);
    motors("dR_unlimited", "Ohm", row.dR_unlimited_Ohm);
    motors("dR", "Ohm", row.dR_Ohm);
    motors("least_dR_unlimited", "Ohm", row.min_dR_unlimited_Ohm);
    motors("least_dR", "Ohm", row.min_dR_Ohm);
    motors("K_DC", "Nm_per_rad", row.K_DC_Nm_per_rad);
    visit("tip_force_N", row.tip_force_N);
    visit("direction_error_deg", row.direction_error_rad * kDegreesPerRadian);
    visit("growth_time_s", row.growth_time_s);
    visit("tripped", row.tripped ? 1.0 : 0.0);
}

using Rows = std::vector<ThermalRow>;

Rows of_phase(const Rows &rows, ThermalPhase phase) {
    Rows some;
    std::copy_if(rows.begin(), rows.end(), std::back_inserter(some),
                 [phase](const ThermalRow &row) { return row.phase == phase; });
    return some;
}

/// A few evenly spaced rows, including the first and the last.
Rows thinned(const Rows &rows) {
    if (rows.size() <= kTableRows) {
        return rows;
    }
    Rows some;
    for (std::size_t i = 0; i < kTableRows; ++i) {
        some.push_back(rows[i * (rows.size() - 1) / (kTableRows - 1)]);
    }
    return some;
}

void cell(std::ostream &out, double value, int width, int decimals) {
    if (std::isnan(value)) {
        print(out, "{:{}}", "", width);
    } else {
        print(out, "{:>{}.{}f}", value, width, decimals);
    }
}

void cells(std::ostream &out, const Vector3 &values, int width, int decimals) {
    out << "  ";
    for (Eigen::Index j = 0; j < 3; ++j) {
        cell(out, values[j], width, decimals);
    }
}

void write_hold(std::ostream &out, const Rows &hold) {
    out << "The contact is held\n"
           "    time         winding °C               dR Ω             K_DC N·m/rad       force    "
           "off\n"
           "       s      1      2      3       1      2      3       1      2      3       N      "
           "°\n";
    for (const ThermalRow &row : thinned(hold)) {
        cell(out, row.time_s, 8, 1);
        cells(out, row.winding_C, 7, 1);
        cells(out, row.dR_Ohm, 7, 3);
        cells(out, row.K_DC_Nm_per_rad, 7, 3);
        cell(out, row.tip_force_N, 8, 3);
        cell(out, row.direction_error_rad * kDegreesPerRadian, 7, 2);
        out << '\n';
    }
    const ThermalRow &first = hold.front();
    const ThermalRow &last = hold.back();
    const Vector3 share = last.K_DC_Nm_per_rad.cwiseQuotient(first.K_DC_Nm_per_rad);
    Eigen::Index softest = 0;
    const double left = share.minCoeff(&softest);
    print(out,
          "K_DC of motor {} fell to {:.0f} % of its initial value, the force from {:.2f} N to "
          "{:.2f} N.\n",
          softest + 1, 100.0 * left, first.tip_force_N, last.tip_force_N);
    if (last.tripped) {
        print(out,
              "At {:.1f} s the safety monitor trips: a winding may exceed its temperature limit.\n",
              last.time_s);
    }
}

/// The summary of R̂ tuned hot.
void write_verdict(std::ostream &out, const Rows &cool) {
    Vector3 min_unlimited = cool.front().min_dR_unlimited_Ohm;
    Vector3 minimum = cool.front().min_dR_Ohm;
    for (const ThermalRow &row : cool) {
        min_unlimited = min_unlimited.cwiseMin(row.min_dR_unlimited_Ohm);
        minimum = minimum.cwiseMin(row.min_dR_Ohm);
    }
    Eigen::Index worst = 0;
    const double worst_Ohm = min_unlimited.minCoeff(&worst);
    print(out, "Without a limit on R̂, dR of motor {} falls to {:.3f} Ω", worst + 1, worst_Ohm);
    const auto over_cancelled = std::find_if(cool.begin(), cool.end(), [](const ThermalRow &row) {
        return !std::isnan(row.growth_time_s);
    });
    if (over_cancelled != cool.end()) {
        print(out, ": over-cancelled from {:.0f} s on, until its current grows e-fold in {:.1f} ms",
              over_cancelled->time_s, 1e3 * cool.back().growth_time_s);
    }
    print(out, ".\nWith it no dR falls below {:.3f} Ω.\n", minimum.minCoeff());
}

void write_cool(std::ostream &out, const Rows &cool) {
    out << "\nR̂ is tuned again on the hot motors, the contact released; dR at the worst angle\n"
           "    time         winding °C         dR Ω without limit       dR Ω with limit     "
           "L/|dR|\n"
           "       s      1      2      3       1      2      3       1      2      3      ms\n";
    for (const ThermalRow &row : thinned(cool)) {
        cell(out, row.time_s, 8, 1);
        cells(out, row.winding_C, 7, 1);
        cells(out, row.min_dR_unlimited_Ohm, 7, 3);
        cells(out, row.min_dR_Ohm, 7, 3);
        cell(out, 1e3 * row.growth_time_s, 8, 2);
        out << '\n';
    }
    write_verdict(out, cool);
}

} // namespace

void write_thermal_csv(std::ostream &out, const std::vector<ThermalRow> &rows) {
    out << "time_s,phase";
    for_each_column({}, [&out](const std::string &column, double) { out << ',' << column; });
    for (const ThermalRow &row : rows) {
        print(out, "\n{:.9g},{}", row.time_s, name(row.phase));
        for_each_column(row, [&out](const std::string &, double value) {
            out << ',';
            if (!std::isnan(value)) {
                print(out, "{:.9g}", value);
            }
        });
    }
    out << '\n';
}

void write_thermal_table(std::ostream &out, const std::vector<ThermalRow> &rows) {
    write_hold(out, of_phase(rows, ThermalPhase::hold));
    if (const Rows cool = of_phase(rows, ThermalPhase::cool); !cool.empty()) {
        write_cool(out, cool);
    }
}

} // namespace springdrive::limits
