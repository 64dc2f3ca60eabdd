#include "engine/lab/limits/thermal_hold.h"

#include "base/degrees.h"
#include "base/input_error.h"
#include "base/print.h"
#include "device/core/motor/motor.h"
#include "device/core/motor/winding_heat.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/motion_control.h"
#include "engine/control/rendered_force.h"
#include "engine/lab/rig/scenario/scenarios.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <initializer_list>
#include <iterator>
#include <ostream>
#include <utility>

namespace springdrive::limits {

namespace {

constexpr double kMaxThermalStep_s = 0.01;
constexpr double kMaxHold_s = 86400.0;
constexpr int kMaxRows = 100000;
constexpr double kMax_K_P_V_per_rad = 1e6; ///< far beyond any stable one

/// A motor with a locked rotor behind a spring drive: its static current (11) warms it, and a guard
/// limits its R̂.
struct HeldMotor {
    device::MotorParameters parameters;
    double theta_rad = 0.0;
    device::WindingTemperature temperature; ///< winding and housing start at the air's
    device::WindingGuard guard;
    double R_hat_asked_Ohm = 0.0;
    double e_W_V = 0.0;

    /// Sets R̂ = R(T, θ) − dR (7), as the operator does.
    void tune(double requested_dR_Ohm) {
        R_hat_asked_Ohm =
            resistance_Ohm() - device::residual_resistance_Ohm(parameters, requested_dR_Ohm);
    }

    /// One step with the current at its start.
    void advance() {
        const double current = current_A();
        temperature.update(current * current * resistance_Ohm());
        guard.update(current);
    }

    [[nodiscard]] double resistance_Ohm() const {
        return device::winding_resistance_Ohm(parameters, temperature.winding_C(), theta_rad);
    }
    [[nodiscard]] double R_hat_allowed_Ohm() const {
        return std::min(R_hat_asked_Ohm, guard.max_cancelled_Ohm());
    }
    [[nodiscard]] double dR_Ohm() const { return resistance_Ohm() - R_hat_allowed_Ohm(); }
    /// (11) at rest, with an unlimited supply.
    [[nodiscard]] double requested_current_A() const { return e_W_V / dR_Ohm(); }
    /// The same, limited to what the supply drives through R.
    [[nodiscard]] double current_A() const {
        const double rail_A = parameters.supply_V / resistance_Ohm();
        return std::clamp(requested_current_A(), -rail_A, rail_A);
    }
    [[nodiscard]] bool is_too_hot() const {
        return guard.max_C() > parameters.thermal.max_winding_C;
    }
};

/// The device locked at one configuration.
class HeldDevice {
public:
    /// @param step_s duration of each `advance`
    HeldDevice(const device::DeviceDescription &device, const ThermalHoldOptions &options,
               double step_s)
        : k_T_(control::torque_constants(device)), options_(options), step_s_(step_s),
          normal_(options.direction.normalized()),
          J_(device::motor_jacobian(device.geometry, options.q_rad)) {
        const Vector3 theta_rad = device::motor_from_joint(device.geometry, options.q_rad);
        for (std::size_t j = 0; j < 3; ++j) {
            const device::MotorParameters &motor = device.motor[j];
            motors_.push_back(
                {motor, theta_rad[static_cast<Eigen::Index>(j)],
                 device::WindingTemperature(motor.thermal, options.ambient_C, step_s),
                 device::WindingGuard(motor, device.amplifier.max_cancelled_Ohm, step_s)});
        }
        tune_and_pull(Vector3::Zero());
        tune_and_pull(theta_gap_rad(control::relative_stiffness(device)));
        check_currents();
    }

    void release_hot() {
        tune_and_pull(Vector3::Zero());
        phase_ = ThermalPhase::cool;
    }

    void advance() {
        for (HeldMotor &motor : motors_) {
            motor.advance();
        }
        ++steps_;
    }

    [[nodiscard]] bool too_hot() const {
        return std::ranges::any_of(motors_, &HeldMotor::is_too_hot);
    }

    [[nodiscard]] ThermalRow row() const;

private:
    /// R̂ for the requested dR, and (10) with everything at rest.
    void tune_and_pull(const Vector3 &theta_gap_rad) {
        for (std::size_t j = 0; j < motors_.size(); ++j) {
            motors_[j].tune(options_.tuning.dR_Ohm);
            motors_[j].e_W_V =
                options_.tuning.K_P_V_per_rad * theta_gap_rad[static_cast<Eigen::Index>(j)];
        }
    }

    [[nodiscard]] Vector3 of_each(double (HeldMotor::*value)() const) const {
        return {(motors_[0].*value)(), (motors_[1].*value)(), (motors_[2].*value)()};
    }
    [[nodiscard]] Vector3 static_stiffness_Nm_per_rad() const {
        return options_.tuning.K_P_V_per_rad * k_T_.cwiseQuotient(of_each(&HeldMotor::dR_Ohm));
    }

    /// θ_Sd − θ of (23) for a set-point along the normal, at the distance at which the tip renders
    /// the requested force. That distance is proportional to 1/α and does not affect locked motors.
    [[nodiscard]] Vector3 theta_gap_rad(const Vector3 &W) const {
        control::Configuration now;
        now.J = J_;
        control::TipSetPoint target;
        target.x_Sd_m = normal_;
        const Vector3 gap_rad =
            control::transpose_map(now, target, control::alpha_bound(J_, W), W).theta_Sd_rad;
        const double force_N =
            control::static_tip_force(J_, static_stiffness_Nm_per_rad(), gap_rad).norm();
        if (!(std::isfinite(force_N) && force_N > 0.0)) {
            throw InputError("the linkage is singular at this q and renders no force; choose "
                             "another configuration");
        }
        return options_.force_N / force_N * gap_rad;
    }

    void check_currents() const;

    Vector3 k_T_;
    ThermalHoldOptions options_;
    double step_s_;
    Vector3 normal_;
    Matrix3 J_;
    std::vector<HeldMotor> motors_;
    ThermalPhase phase_ = ThermalPhase::hold;
    long steps_ = 0;
};

/// The start is the most demanding moment for a motor: from then on dR only rises, and the current
/// falls.
void HeldDevice::check_currents() const {
    for (std::size_t j = 0; j < motors_.size(); ++j) {
        const device::MotorParameters &motor = motors_[j].parameters;
        const double current_A = std::abs(motors_[j].requested_current_A());
        const double limit_A =
            std::min(motor.peak_current_A, motor.supply_V / motors_[j].resistance_Ohm());
        if (!(current_A <= limit_A)) {
            throw InputError(fmt::format(
                "a hold of {:.3g} N needs {:.3g} A of motor {}, whose peak current and supply "
                "allow {:.3g} A; hold at most {:.3g} N",
                options_.force_N, current_A, j + 1, limit_A,
                options_.force_N * limit_A / current_A));
        }
    }
}

ThermalRow HeldDevice::row() const {
    ThermalRow row;
    row.time_s = static_cast<double>(steps_) * step_s_;
    row.phase = phase_;
    double fastest_per_s = 0.0;
    for (Eigen::Index j = 0; j < 3; ++j) {
        const HeldMotor &motor = motors_[static_cast<std::size_t>(j)];
        const double winding_C = motor.temperature.winding_C();
        const double min_Ohm = device::min_resistance_Ohm(motor.parameters, winding_C);
        row.winding_C[j] = winding_C;
        row.R_hat_asked_Ohm[j] = motor.R_hat_asked_Ohm;
        row.R_hat_allowed_Ohm[j] = motor.R_hat_allowed_Ohm();
        row.dR_unlimited_Ohm[j] = motor.resistance_Ohm() - motor.R_hat_asked_Ohm;
        row.dR_Ohm[j] = motor.dR_Ohm();
        row.min_dR_unlimited_Ohm[j] = min_Ohm - motor.R_hat_asked_Ohm;
        row.min_dR_Ohm[j] = min_Ohm - motor.R_hat_allowed_Ohm();
        fastest_per_s =
            std::max(fastest_per_s, -row.min_dR_unlimited_Ohm[j] / motor.parameters.inductance_H);
    }
    if (fastest_per_s > 0.0) {
        row.growth_time_s = 1.0 / fastest_per_s;
    }
    row.K_DC_Nm_per_rad = static_stiffness_Nm_per_rad();
    const Vector3 force_N = control::static_tip_force(J_, k_T_, of_each(&HeldMotor::current_A));
    row.tip_force_N = force_N.norm();
    row.direction_error_rad = control::direction_error_rad(force_N, normal_);
    row.tripped = too_hot();
    return row;
}

[[noreturn]] void refuse(const char *what, double value, const char *unit, const char *range,
                         double minimum, const char *range_end, double maximum) {
    throw InputError(fmt::format("thermal hold: {} is {:g}{}; it must be {}{:g}{}{:g}{}", what,
                                 value, unit, range, minimum, range_end, maximum, unit));
}

void check_range(const char *what, double value, double minimum, double maximum, const char *unit) {
    if (!(value >= minimum && value <= maximum)) { // a NaN too
        refuse(what, value, unit, "from ", minimum, " to ", maximum);
    }
}

void check_positive(const char *what, double value, double maximum, const char *unit) {
    if (!(value > 0.0 && value <= maximum)) {
        refuse(what, value, unit, "above ", 0.0, " and at most ", maximum);
    }
}

void check(const device::DeviceDescription &device, const ThermalHoldOptions &options) {
    check_positive("the force", options.force_N, device.limits.tip_force_N, " N");
    check_positive("the time", options.seconds, kMaxHold_s, " s");
    check_range("the number of rows", options.rows, 2, kMaxRows, "");
    check_positive("K_P", options.tuning.K_P_V_per_rad, kMax_K_P_V_per_rad, " V/rad");
    check_range("the air", options.ambient_C, device::kColdestAir_C, device::kWarmestAir_C, " °C");
    rig::check_configuration(device, options.q_rad);
    if (!(options.direction.allFinite() && options.direction.norm() > 0.0)) {
        throw InputError("thermal hold: the direction must be finite and have a length");
    }
}

using Rows = std::vector<ThermalRow>;

Rows of_phase(const Rows &rows, ThermalPhase phase) {
    Rows some;
    std::ranges::copy_if(rows, std::back_inserter(some),
                         [phase](const ThermalRow &row) { return row.phase == phase; });
    return some;
}

/// A few evenly spaced rows, including the first and the last: enough to show the course of a
/// phase.
Rows thinned(const Rows &rows) {
    constexpr std::size_t kTableRows = 11;
    if (rows.size() <= kTableRows) {
        return rows;
    }
    Rows some;
    for (std::size_t i = 0; i < kTableRows; ++i) {
        some.push_back(rows[i * (rows.size() - 1) / (kTableRows - 1)]);
    }
    return some;
}

/// Adds a row of some numbers, and of triples of the motors between them.
void add_row(Table &table, std::vector<Cell> cells, std::initializer_list<Vector3> of_motors,
             std::initializer_list<Cell> last) {
    for (const Vector3 &three : of_motors) {
        cells.insert(cells.end(), {three[0], three[1], three[2]});
    }
    cells.insert(cells.end(), last);
    table.rows.push_back(std::move(cells));
}

void write_hold(std::ostream &out, const Rows &hold) {
    Table table = Table::with_columns(
        "time\ns:.1f,T1\n°C:.1f,T2\n°C:.1f,T3\n°C:.1f,dR1\nΩ,dR2\nΩ,dR3\nΩ,K_DC1\nN·m/rad,"
        "K_DC2\nN·m/rad,K_DC3\nN·m/rad,force\nN,off\n°:.2f",
        ".3f");
    for (const ThermalRow &row : thinned(hold)) {
        add_row(table, {row.time_s}, {row.winding_C, row.dR_Ohm, row.K_DC_Nm_per_rad},
                {row.tip_force_N, row.direction_error_rad * kDegreesPerRadian});
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
    const auto over_cancelled = std::ranges::find_if(
        cool, [](const ThermalRow &row) { return !std::isnan(row.growth_time_s); });
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
        add_row(table, {row.time_s}, {row.winding_C, row.min_dR_unlimited_Ohm, row.min_dR_Ohm},
                {1e3 * row.growth_time_s});
    }
    out << "\nR̂ is tuned again on the hot motors, the contact released; dR [Ω] at the worst "
           "angle\n";
    write_text(out, table);
    write_verdict(out, cool);
}

} // namespace

std::vector<ThermalRow> thermal_hold(const device::DeviceDescription &device,
                                     const ThermalHoldOptions &options) {
    check(device, options);
    const double span_s = options.seconds / (options.rows - 1);
    const long steps_a_row = std::lround(std::max(1.0, std::ceil(span_s / kMaxThermalStep_s)));
    HeldDevice held(device, options, span_s / static_cast<double>(steps_a_row));
    std::vector<ThermalRow> rows;
    rows.reserve(2 * static_cast<std::size_t>(options.rows));
    for (const ThermalPhase phase : {ThermalPhase::hold, ThermalPhase::cool}) {
        if (phase == ThermalPhase::cool) {
            held.release_hot();
        }
        rows.push_back(held.row());
        for (int row = 1; row < options.rows; ++row) {
            for (long step = 0; step < steps_a_row && !held.too_hot(); ++step) {
                held.advance();
            }
            rows.push_back(held.row());
            if (rows.back().tripped) {
                return rows;
            }
        }
    }
    return rows;
}

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
        add_row(table, {row.time_s, row.phase == ThermalPhase::hold ? "hold" : "cool"},
                {row.winding_C, row.R_hat_asked_Ohm, row.R_hat_allowed_Ohm, row.dR_unlimited_Ohm,
                 row.dR_Ohm, row.min_dR_unlimited_Ohm, row.min_dR_Ohm, row.K_DC_Nm_per_rad},
                {row.tip_force_N, row.direction_error_rad * kDegreesPerRadian, row.growth_time_s,
                 row.tripped});
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
