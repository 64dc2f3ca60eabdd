// The outputs of thermal_hold.h.
#include "base/degrees.h"
#include "base/print.h"
#include "engine/lab/limits/thermal_hold.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <ostream>

namespace springdrive::limits {

namespace {

/// Enough to show the course of a phase.
constexpr std::size_t kTableRows = 11;

const char *name(ThermalPhase phase) { return phase == ThermalPhase::hold ? "hold" : "cool"; }

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

void append(std::vector<Cell> &row, const Vector3 &of_motors) {
    row.insert(row.end(), {of_motors[0], of_motors[1], of_motors[2]});
}

void write_hold(std::ostream &out, const Rows &hold) {
    Table table = Table::with_columns(
        "time\ns:.1f,T1\n°C:.1f,T2\n°C:.1f,T3\n°C:.1f,dR1\nΩ,dR2\nΩ,dR3\nΩ,K_DC1\nN·m/rad,"
        "K_DC2\nN·m/rad,K_DC3\nN·m/rad,force\nN,off\n°:.2f",
        ".3f");
    for (const ThermalRow &row : thinned(hold)) {
        std::vector<Cell> &cells = table.rows.emplace_back(1, row.time_s);
        append(cells, row.winding_C);
        append(cells, row.dR_Ohm);
        append(cells, row.K_DC_Nm_per_rad);
        cells.insert(cells.end(), {row.tip_force_N, row.direction_error_rad * kDegreesPerRadian});
    }
    out << "The contact is held; T are the windings' temperatures\n";
    write_text(out, table);
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
    Table table = Table::with_columns(
        "time\ns:.1f,T1\n°C:.1f,T2\n°C:.1f,T3\n°C:.1f,dR1\nno limit,dR2\nno limit,dR3\nno limit,"
        "dR1\nlimit,dR2\nlimit,dR3\nlimit,L/|dR|\nms:.2f",
        ".3f");
    for (const ThermalRow &row : thinned(cool)) {
        std::vector<Cell> &cells = table.rows.emplace_back(1, row.time_s);
        append(cells, row.winding_C);
        append(cells, row.min_dR_unlimited_Ohm);
        append(cells, row.min_dR_Ohm);
        cells.emplace_back(1e3 * row.growth_time_s);
    }
    out << "\nR̂ is tuned again on the hot motors, the contact released; dR [Ω] at the worst "
           "angle\n";
    write_text(out, table);
    write_verdict(out, cool);
}

} // namespace

Table thermal_table(const std::vector<ThermalRow> &rows) {
    Table table = Table::with_columns(
        "time_s,phase,winding1_C,winding2_C,winding3_C,"
        "R_hat_asked1_Ohm,R_hat_asked2_Ohm,R_hat_asked3_Ohm,"
        "R_hat_allowed1_Ohm,R_hat_allowed2_Ohm,R_hat_allowed3_Ohm,"
        "dR_unlimited1_Ohm,dR_unlimited2_Ohm,dR_unlimited3_Ohm,dR1_Ohm,dR2_Ohm,dR3_Ohm,"
        "least_dR_unlimited1_Ohm,least_dR_unlimited2_Ohm,least_dR_unlimited3_Ohm,"
        "least_dR1_Ohm,least_dR2_Ohm,least_dR3_Ohm,"
        "K_DC1_Nm_per_rad,K_DC2_Nm_per_rad,K_DC3_Nm_per_rad,"
        "tip_force_N,direction_error_deg,growth_time_s,tripped",
        ".9g");
    for (const ThermalRow &row : rows) {
        std::vector<Cell> cells{row.time_s, name(row.phase)};
        for (const Vector3 &of_motors :
             {row.winding_C, row.R_hat_asked_Ohm, row.R_hat_allowed_Ohm, row.dR_unlimited_Ohm,
              row.dR_Ohm, row.min_dR_unlimited_Ohm, row.min_dR_Ohm, row.K_DC_Nm_per_rad}) {
            append(cells, of_motors);
        }
        cells.insert(cells.end(), {row.tip_force_N, row.direction_error_rad * kDegreesPerRadian,
                                   row.growth_time_s, row.tripped});
        table.rows.push_back(std::move(cells));
    }
    return table;
}

void write_thermal_table(std::ostream &out, const std::vector<ThermalRow> &rows) {
    write_hold(out, of_phase(rows, ThermalPhase::hold));
    if (const Rows cool = of_phase(rows, ThermalPhase::cool); !cool.empty()) {
        write_cool(out, cool);
    }
}

} // namespace springdrive::limits
