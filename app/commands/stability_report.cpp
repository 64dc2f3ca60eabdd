#include "app/commands/stability_report.h"

#include "base/print.h"
#include "base/quoting.h"
#include "base/table.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/coupling.h"
#include "engine/control/tuning.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

namespace springdrive::app {

namespace {

using Json = nlohmann::ordered_json;

std::string who(const loops::StabilityCase &which, const loops::LoopMember &member) {
    if (which.rotor) {
        return "the motor given, " + loops::hand_text(member.hand.name);
    }
    return which.freedom == loops::Freedom::three_motors
               ? "all motors, " + loops::hand_text(member.hand.name)
               : "motor " + std::to_string(member.motor + 1) + ", " +
                     loops::hand_text(member.hand.name);
}

void write_setting(std::ostream &out, const StabilityReport &report) {
    const loops::StabilityCase &which = report.which;
    const control::Tuning &tuning = which.tuning;
    print(out, "{}, servo {:.6g} Hz, delay {:g}, ", which.device.name, 1.0 / which.period_s,
          which.delay_periods);
    if (which.drive == device::AmplifierKind::current_drive) {
        print(out, "current drive: wall K {:.4g} N/m, B {:.4g} N·s/m, λ {:.4g} rad/s\n",
              which.wall.stiffness_N_per_m, which.wall.damping_Ns_per_m, tuning.lambda_rad_per_s);
    } else {
        print(out, "spring drive: dR {:.4g} Ω, K_P {:.4g} V/rad, K_D {:.4g} V·s/rad, ",
              which.dR_Ohm(which.device.motor[0]), tuning.K_P_V_per_rad, tuning.K_D_Vs_per_rad);
        print(out, "λ {:.4g} rad/s, η {:.3g}, {}\n", tuning.lambda_rad_per_s, tuning.eta,
              control::label_of(tuning.map));
    }
    print(out, "hands: {}, ", which.hands.size());
    out << (which.rotor ? "one motor with a given inertia"
            : which.freedom == loops::Freedom::three_motors
                ? "the whole linkage, its tip held at a point"
                : "each motor by itself")
        << "\n\n";
}

void write_verdict(std::ostream &out, const StabilityReport &report) {
    print(out, "predicted  {:<8}  largest eigenvalue {:.6f} ({})\n",
          report.worst.is_stable() ? "stable" : "UNSTABLE", report.worst.eigenvalue,
          who(report.which, report.worst.member));
    print(out, "simulated  {:<8}  released 1 mm aside, with encoder counts and supply limits\n",
          report.stable_simulated ? "stable" : "UNSTABLE");
    if (report.which.drive == device::AmplifierKind::current_drive) {
        print(out,
              "2b/(T(1 + 2d) + 2/ω)  {:.4g} N/m at the tip: Colgate and Schenkel's limit for a "
              "heavy device without hand and B,\n",
              passive_wall_N_per_m(report.which));
        out << "           with a delay of d periods and this amplifier's bandwidth ω; minimum of "
               "all motors\n";
    }
    if (report.worst.is_stable() && !report.stable_simulated) {
        out << "           they differ because encoder counts sustain a slowly decaying motion\n";
    }
}

/// To the prediction.
Cell ratio(const std::optional<double> &found, const limits::StabilityLimit &limit) {
    return found && limit.predicted != 0.0 ? Cell(*found / limit.predicted) : Cell();
}

void write_limits(std::ostream &out, const StabilityReport &report) {
    const loops::StabilityParameter &varied = *report.varied;
    print(out, "\n{} from {:.5g} to {:.5g} {}: ", varied.symbol, report.range.from, report.range.to,
          varied.unit);
    if (report.stable_throughout) {
        out << "no limit within it, predicted "
            << (*report.stable_throughout ? "stable" : "unstable") << " throughout\n";
        return;
    }
    out << (report.limits.size() == 1 ? "one limit\n\n" : "more than one limit\n\n");
    Table table = Table::with_columns(
        "stable,predicted:.6g,no effects:.5g,ratio:.3f,counts and supply:.5g,ratio:.3f,"
        "+ friction:.5g,ratio:.3f,limited by");
    for (const limits::StabilityLimit &limit : report.limits) {
        std::vector<Cell> row{limit.stable_below ? "up to" : "from", limit.predicted};
        for (const std::optional<double> &found :
             {limit.simulated_linear, limit.simulated, limit.simulated_all}) {
            row.emplace_back(found);
            row.push_back(ratio(found, limit));
        }
        loops::StabilityCase there = report.which;
        varied.set(there, limit.predicted);
        row.emplace_back(who(there, limit.worst));
        table.rows.push_back(std::move(row));
    }
    write_text(out, table);
    out << "\nEach simulated limit is followed by its ratio to the prediction. Counts can sustain\n"
           "a slowly decaying motion, and cease to do so farther on: the limit given is the first\n"
           "from the stable side. Friction stops small motions. Slow motions are simulated for\n"
           "up to 30 s; one that grows by less than some 0.05/s can be mistaken for a decaying\n"
           "one.\n";
}

Json found_json(const std::optional<double> &found) { return found ? Json(*found) : Json(nullptr); }

Json throughout_json(const std::optional<bool> &stable) {
    return stable ? Json(*stable ? "stable" : "unstable") : Json(nullptr);
}

Json member_json(const loops::StabilityCase &which, const loops::LoopMember &member) {
    const bool one = which.freedom == loops::Freedom::one_motor && !which.rotor;
    return {{"motor", one ? Json(member.motor + 1) : Json(nullptr)},
            {"hand", member.hand.name},
            {"hand_mass_kg", member.hand.mass_kg},
            {"hand_damping_Ns_per_m", member.hand.damping_Ns_per_m},
            {"hand_stiffness_N_per_m", member.hand.stiffness_N_per_m}};
}

} // namespace

double passive_wall_N_per_m(const loops::StabilityCase &which) {
    loops::StabilityCase each = which;
    each.freedom = loops::Freedom::one_motor;
    each.hands = {loops::no_hand()};
    const Matrix3 J = device::motor_jacobian(which.device.geometry, which.q_rad);
    const double late_s =
        which.period_s * (1.0 + 2.0 * which.delay_periods) +
        2.0 / (2.0 * std::numbers::pi * which.device.amplifier.current_bandwidth_hz);
    double minimum = HUGE_VAL;
    for (const loops::LoopMember &member : loops::members(each)) {
        const double b = loops::driven_load(each, member).damping_Nms_per_rad(0, 0);
        minimum = std::min(minimum, 2.0 * b / late_s / J.col(member.motor).squaredNorm());
    }
    return minimum;
}

void write_stability_table(std::ostream &out, const StabilityReport &report) {
    write_setting(out, report);
    write_verdict(out, report);
    if (report.varied != nullptr) {
        write_limits(out, report);
    }
}

void write_stability_json(std::ostream &out, const StabilityReport &report) {
    Json json;
    json["stable"] = report.is_stable();
    json["predicted"] = {{"stable", report.worst.is_stable()},
                         {"largest_eigenvalue", report.worst.eigenvalue},
                         {"worst", member_json(report.which, report.worst.member)}};
    json["simulated"] = {{"stable", report.stable_simulated}};
    if (report.varied != nullptr) {
        json["vary"] = report.varied->name;
        json["unit"] = report.varied->unit;
        json["from"] = report.range.from;
        json["to"] = report.range.to;
        json["throughout"] = throughout_json(report.stable_throughout);
        json["limits"] = Json::array();
        for (const limits::StabilityLimit &limit : report.limits) {
            json["limits"].push_back(
                {{"stable", limit.stable_below ? "below" : "above"},
                 {"predicted", limit.predicted},
                 {"simulated_without_effects", found_json(limit.simulated_linear)},
                 {"simulated", found_json(limit.simulated)},
                 {"simulated_with_friction", found_json(limit.simulated_all)},
                 {"ratio", limit.simulated && limit.predicted != 0.0
                               ? Json(*limit.simulated / limit.predicted)
                               : Json(nullptr)},
                 {"limited_by", member_json(report.which, limit.worst)}});
        }
    }
    out << json_text(json) << '\n';
}

} // namespace springdrive::app
