// The list of all telemetry columns, read by records, exports and replays.
//
// Each member of ServoSample needs a line here; a test fails if one is missing. Names end in their
// unit; `unit` is the unit alone, "1" if there is none.
#pragma once

#include "engine/control/tuning.h"
#include "engine/servo/servo_sample.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <string_view>

namespace springdrive::record {

namespace columns {

using Names3 = std::array<std::string_view, 3>;

/// "limit_" before the name of a safety limit, concatenated at compile time.
struct LimitName {
    std::array<char, 40> text{};
    std::size_t length = 0;

    [[nodiscard]] constexpr std::string_view view() const { return {text.data(), length}; }
    constexpr void append(std::string_view part) {
        std::copy(part.begin(), part.end(), text.begin() + static_cast<std::ptrdiff_t>(length));
        length += part.size();
    }
};

inline constexpr auto kLimitNames = [] {
    std::array<LimitName, servo::kSafetyLimits.size()> names{};
    for (std::size_t i = 0; i < names.size(); ++i) {
        names[i].append("limit_");
        names[i].append(servo::kSafetyLimits[i].name);
    }
    return names;
}();

/// Panels show some limits in units other than SI; the name always ends in the SI unit.
[[nodiscard]] constexpr std::string_view si_unit(const servo::SafetyLimit &limit) {
    const std::string_view name = limit.name;
    const std::string_view shown = limit.unit;
    if (limit.shown_per_si != 1.0) {
        return name.substr(name.rfind('_') + 1);
    }
    return shown.empty() ? "1" : shown;
}

[[nodiscard]] constexpr std::string_view si_unit(const control::Parameter &parameter) {
    return parameter.unit == "–" ? "1" : parameter.unit;
}

/// Visits the three components of anything that can be indexed.
template <typename Visit, typename Vector>
void visit_three(Visit &visit, const Names3 &names, std::string_view unit, Vector &v) {
    visit(names[0], unit, v[0]);
    visit(names[1], unit, v[1]);
    visit(names[2], unit, v[2]);
}

template <typename ContactOf, typename Visit> void of_contact(ContactOf &c, Visit &visit) {
    visit("touching", "1", c.touching);
    visit_three(visit, {"proxy_x_m", "proxy_y_m", "proxy_z_m"}, "m", c.x0_m);
    // P, row by row.
    visit("allowed_motion_xx", "1", c.tangent_projector(0, 0));
    visit("allowed_motion_xy", "1", c.tangent_projector(0, 1));
    visit("allowed_motion_xz", "1", c.tangent_projector(0, 2));
    visit("allowed_motion_yx", "1", c.tangent_projector(1, 0));
    visit("allowed_motion_yy", "1", c.tangent_projector(1, 1));
    visit("allowed_motion_yz", "1", c.tangent_projector(1, 2));
    visit("allowed_motion_zx", "1", c.tangent_projector(2, 0));
    visit("allowed_motion_zy", "1", c.tangent_projector(2, 1));
    visit("allowed_motion_zz", "1", c.tangent_projector(2, 2));
    visit_three(visit, {"normal_x", "normal_y", "normal_z"}, "1", c.normal);
    visit("surface_eta", "1", c.eta);
    visit("active_constraints", "1", c.active_constraints);
    visit("sticking", "1", c.sticking);
    visit("settled", "1", c.settled);
    visit_three(visit, {"surface_x_m", "surface_y_m", "surface_z_m"}, "m", c.surface_m);
    visit_three(visit, {"barycentric1", "barycentric2", "barycentric3"}, "1", c.barycentric);
    visit("triangle", "1", c.triangle);
    visit("material", "1", c.material);
}

/// Named as in `kParameters`, so that a record uses the names of tuning files.
template <typename TuningOf, typename Visit> void of_tuning(TuningOf &t, Visit &visit) {
    for (const control::Parameter &parameter : control::kParameters) {
        visit(parameter.name, si_unit(parameter), t.*parameter.value);
    }
    visit("map", "1", t.map);
    visit("alpha_mode", "1", t.alpha_mode);
}

template <typename Sample, typename Visit> void of_law(Sample &s, Visit &visit) {
    visit("eta_in_force", "1", s.eta);
    visit("global_alpha_rad2_per_m2", "rad²/m²", s.global_alpha_rad2_per_m2);
    visit("alpha_in_force_rad2_per_m2", "rad²/m²", s.alpha_rad2_per_m2);
    visit("alpha_bound_rad2_per_m2", "rad²/m²", s.alpha_bound_rad2_per_m2);
    visit_three(visit, {"x_Sd_x_m", "x_Sd_y_m", "x_Sd_z_m"}, "m", s.x_Sd_m);
    visit_three(visit, {"theta_Sd1_rad", "theta_Sd2_rad", "theta_Sd3_rad"}, "rad", s.theta_Sd_rad);
    visit("inverse_possible", "1", s.inverse_possible);
    visit_three(visit, {"carried1_V", "carried2_V", "carried3_V"}, "V", s.transfer_offset_V);
    // command.number equals measurement_number; resets_faults and voids_zero concern the device
    // alone
    visit("command_mode", "1", s.command.mode);
    visit_three(visit, {"e_W1_V", "e_W2_V", "e_W3_V"}, "V", s.command.e_W_V);
    constexpr std::array<std::array<std::string_view, 13>, 3> kMotorNames{{
        {"R1_Ohm", "R1_deviation_Ohm", "R_mean1_Ohm", "R_mean1_deviation_Ohm", "k_T1_Nm_per_A",
         "offset1_A", "R_observed1", "R_trusted1", "V_b1_V", "V_b1_deviation_V", "R_hat_max1_Ohm",
         "trim1_V", "load1"},
        {"R2_Ohm", "R2_deviation_Ohm", "R_mean2_Ohm", "R_mean2_deviation_Ohm", "k_T2_Nm_per_A",
         "offset2_A", "R_observed2", "R_trusted2", "V_b2_V", "V_b2_deviation_V", "R_hat_max2_Ohm",
         "trim2_V", "load2"},
        {"R3_Ohm", "R3_deviation_Ohm", "R_mean3_Ohm", "R_mean3_deviation_Ohm", "k_T3_Nm_per_A",
         "offset3_A", "R_observed3", "R_trusted3", "V_b3_V", "V_b3_deviation_V", "R_hat_max3_Ohm",
         "trim3_V", "load3"},
    }};
    for (std::size_t motor = 0; motor < 3; ++motor) {
        auto &observed = s.motor[motor];
        visit(kMotorNames[motor][0], "Ω", observed.here.resistance_Ohm);
        visit(kMotorNames[motor][1], "Ω", observed.here.deviation_Ohm);
        visit(kMotorNames[motor][2], "Ω", observed.mean.resistance_Ohm);
        visit(kMotorNames[motor][3], "Ω", observed.mean.deviation_Ohm);
        visit(kMotorNames[motor][4], "N·m/A", observed.torque_constant_Nm_per_A);
        visit(kMotorNames[motor][5], "A", observed.offset_A);
        visit(kMotorNames[motor][6], "1", observed.is_observed);
        visit(kMotorNames[motor][7], "1", observed.is_trusted);
        visit(kMotorNames[motor][8], "V", observed.brush_voltage_V);
        visit(kMotorNames[motor][9], "V", observed.brush_deviation_V);
        visit(kMotorNames[motor][10], "Ω", observed.R_hat_limit_Ohm);
        visit(kMotorNames[motor][11], "V", observed.trim_V);
        visit(kMotorNames[motor][12], "1", observed.load);
    }
    visit("lag_s", "s", s.lag_s);
    visit_three(visit, {"dR1_Ohm", "dR2_Ohm", "dR3_Ohm"}, "Ω", s.dR_Ohm);
    visit_three(visit, {"stiffness_share1", "stiffness_share2", "stiffness_share3"}, "1",
                s.stiffness_share);
    visit_three(visit, {"R_hat1_Ohm", "R_hat2_Ohm", "R_hat3_Ohm"}, "Ω",
                s.command.cancelled_resistance_Ohm);
    visit_three(visit, {"current1_A", "current2_A", "current3_A"}, "A", s.current_A);
    visit_three(visit, {"force_x_N", "force_y_N", "force_z_N"}, "N", s.tip_force_N);
    visit("rendered_error_rad", "rad", s.rendered_error_rad);
    visit("inverse_error_rad", "rad", s.inverse_error_rad);
    visit("transpose_error_rad", "rad", s.transpose_error_rad);
}

template <typename Sample, typename Visit> void of_safety(Sample &s, Visit &visit) {
    visit("safety_state", "1", s.safety.state);
    visit("trip_cause", "1", s.safety.cause);
    visit("trip_measured", "SI", s.safety.measured);
    visit("trip_limit", "SI", s.safety.limit);
    visit("ramp", "1", s.safety.ramp);
    visit("held_stop", "1", s.safety.held_stop);
    visit("held_back_force", "1", s.active_limits.force);
    visit("held_back_voltage", "1", s.active_limits.voltage);
    visit("held_back_at_edge", "1", s.active_limits.at_edge);
    for (std::size_t i = 0; i < servo::kSafetyLimits.size(); ++i) {
        visit(kLimitNames[i].view(), si_unit(servo::kSafetyLimits[i]),
              s.limits.*servo::kSafetyLimits[i].value);
    }
    visit("generated_energy_J", "J", s.generated_energy_J);
    constexpr std::array<std::array<std::string_view, 6>, 3> kWindingNames{{
        {"winding_least1_C", "winding_greatest1_C", "R_hat_limit1_Ohm", "R_hat_limited1",
         "R_contradicted1", "generated1"},
        {"winding_least2_C", "winding_greatest2_C", "R_hat_limit2_Ohm", "R_hat_limited2",
         "R_contradicted2", "generated2"},
        {"winding_least3_C", "winding_greatest3_C", "R_hat_limit3_Ohm", "R_hat_limited3",
         "R_contradicted3", "generated3"},
    }};
    // max_housing_C is for the next start alone
    for (std::size_t motor = 0; motor < 3; ++motor) {
        visit(kWindingNames[motor][0], "°C", s.winding[motor].min_C);
        visit(kWindingNames[motor][1], "°C", s.winding[motor].max_C);
        visit(kWindingNames[motor][2], "Ω", s.winding[motor].R_hat_limit_Ohm);
        visit(kWindingNames[motor][3], "1", s.winding[motor].is_limited);
        visit(kWindingNames[motor][4], "1", s.winding[motor].is_contradicted);
        visit(kWindingNames[motor][5], "1", s.winding[motor].generates);
    }
}

} // namespace columns

/// Calls visit(name, unit, reference) for each scalar of the sample, always in the same order.
/// @param sample  a ServoSample or const ServoSample
/// @param visit   must accept string_view, string_view and a reference to each of std::uint64_t,
///                std::uint32_t, std::uint16_t, std::int32_t, double, bool and one-byte enums
template <typename Sample, typename Visit> void for_each_column(Sample &sample, Visit &&visit) {
    using columns::visit_three;
    visit("tick", "1", sample.tick);
    visit("time_s", "s", sample.time_s);
    visit("measurement_number", "1", sample.measurement_number);
    visit("measured_s", "s", sample.measured_s);
    visit("arrival", "1", sample.arrival);
    visit("health", "1", sample.health);
    visit("board_faults", "1", sample.board_faults);
    visit("supply_V", "V", sample.supply_V);
    visit("since_last_s", "s", sample.since_last_s);
    visit_three(visit, {"counts1", "counts2", "counts3"}, "1", sample.counts);
    visit_three(visit, {"theta1_rad", "theta2_rad", "theta3_rad"}, "rad", sample.theta_rad);
    visit_three(visit, {"theta_rate1_rad_per_s", "theta_rate2_rad_per_s", "theta_rate3_rad_per_s"},
                "rad/s", sample.theta_rate_rad_per_s);
    visit_three(visit, {"tip_x_m", "tip_y_m", "tip_z_m"}, "m", sample.tip_m);
    columns::of_contact(sample.contact, visit);
    visit("scene_id", "1", sample.scene_id);
    columns::of_tuning(sample.tuning, visit);
    columns::of_law(sample, visit);
    columns::of_safety(sample, visit);
    visit("missed_deadlines", "1", sample.missed_deadlines);
    visit("missed_in_a_row", "1", sample.missed_in_a_row);
    visit("missed_periods", "1", sample.missed_periods);
    visit("clock_s", "s", sample.clock_s);
    visit("lateness_s", "s", sample.lateness_s);
    visit("period_s", "s", sample.period_s);
    visit("read_s", "s", sample.read_s);
    visit("compute_s", "s", sample.compute_s);
    visit("write_s", "s", sample.write_s);
}

} // namespace springdrive::record
