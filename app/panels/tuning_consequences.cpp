#include "app/panels/panels.h"

#include "app/plots/channels.h"
#include "app/widgets/widgets.h"
#include "base/print.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/coupling.h"
#include "engine/control/tuning.h"
#include "engine/control/winding_observer.h"

#include <Eigen/LU>

#include <algorithm>
#include <array>

namespace springdrive::app {

namespace {

/// A motor's active dR: larger than requested if too little is known of its R.
double dR_of_motor_Ohm(const session::Session &session, std::size_t motor) {
    const servo::ServoSample &now = session.latest();
    const control::ObservedMotor &R = now.motor[motor];
    const double dR_Ohm = std::max(session.tuning().now().dR_Ohm, control::held_up_dR_Ohm(R));
    const servo::WindingStatus &winding = now.winding[motor];
    return winding.is_limited ? std::max(dR_Ohm, R.mean.resistance_Ohm - winding.R_hat_limit_Ohm)
                              : dR_Ohm;
}

/// With K_P raised where dR is held up, as far as the law does that.
double acting_K_DC_Nm_per_rad(const session::Session &session) {
    return session.latest().stiffness_share.maxCoeff() *
           control::mean_static_stiffness_Nm_per_rad(session.description(), session.tuning().now());
}

/// A number with its unit, laid out as `label   value unit`; explained by its label.
void show(const char *label, CheckedFormat<double> format, double value, const char *unit) {
    ImGui::TableNextColumn();
    const ui::ExplainedRow row(explanation_of(label, unit), ui::ExplainedRow::Reach::items);
    ui::text(kFaintInk, "{}", label);
    ImGui::TableNextColumn();
    const ui::Scope scope(label);
    std::array<char, 32> digits{};
    print(digits, format, value);
    ui::text(kInk, "{} {}", digits.data(), unit);
}

} // namespace

double active_dR_Ohm(const session::Session &session) {
    return std::max(
        {dR_of_motor_Ohm(session, 0), dR_of_motor_Ohm(session, 1), dR_of_motor_Ohm(session, 2)});
}

void draw_observed_resistances(session::Session &session) {
    const ui::ExplainedRow row(explanation_of("observe R", "Ω"));
    bool is_requested = session.wants_resistance_observed();
    if (ui::checkbox("observe R", is_requested)) {
        session.observe_resistance(is_requested);
    }
    const control::ObservedMotors &R = session.latest().motor;
    if (!R.front().is_observed) {
        if (is_requested) {
            ImGui::SameLine();
            ui::text(kFaintInk, "no inductance");
        }
        return;
    }
    constexpr double kUnknown_Ohm = 0.02;
    for (std::size_t j = 0; j < R.size(); ++j) {
        const control::ResistanceEstimate &mean = R[j].mean;
        const bool is_known = R[j].is_trusted && mean.deviation_Ohm < kUnknown_Ohm;
        ImGui::SameLine();
        ui::text(R[j].is_trusted ? kFaintInk : kDanger, "{}",
                 is_known ? ui::formatted("{:.2f}", mean.resistance_Ohm)
                          : ui::formatted("{:.1f}?", mean.resistance_Ohm));
        ui::explain(
            ui::formatted("motor {}: R is {:.4f} ± {:.4f} Ω, averaged over the commutator's\n"
                          "angles, as the amplifier's sensor sees it; k_T is {:.4f} N·m/A,\n"
                          "the sensor's offset {:.1f} mA",
                          j + 1, mean.resistance_Ohm, mean.deviation_Ohm,
                          R[j].torque_constant_Nm_per_A, 1e3 * R[j].offset_A));
    }
    ImGui::SameLine();
    ui::text(kFaintInk, "Ω");
}

void show_held_up_dR(const session::Session &session) {
    const servo::ServoSample &now = session.latest();
    const double requested_Ohm = session.tuning().now().dR_Ohm;
    double left_s = 0.0;
    for (std::size_t j = 0; j < now.motor.size(); ++j) {
        if (!now.motor[j].is_trusted) {
            ui::text(kDanger, "motor {}: its current contradicts its motion", j + 1);
            ui::explain("a current sensor is wrong, or the motor is not the file's;\n"
                        "to observe anew, switch \"observe R\" off and on");
        }
        left_s = std::max(
            left_s, control::touch_left_s(session.description(), j, now.motor[j], requested_Ohm,
                                          now.current_A[static_cast<Eigen::Index>(j)]));
    }
    const double active_Ohm = active_dR_Ohm(session);
    if (!(active_Ohm > requested_Ohm)) {
        return;
    }
    constexpr double kTooLong_s = 20.0;
    const bool are_trusted = std::ranges::all_of(now.motor, &control::ObservedMotor::is_trusted);
    if (!are_trusted) {
        ui::text(kDanger, "dR is held at {:.3f} Ω", active_Ohm);
    } else if (left_s == 0.0) {
        ui::text(kDanger, "dR is held at {:.3f} Ω by the winding guard", active_Ohm);
    } else if (left_s > kTooLong_s) {
        ui::text(kDanger, "dR is held at {:.3f} Ω: press on a surface", active_Ohm);
    } else {
        ui::text(kDanger, "dR is held at {:.3f} Ω: touch on, {:.1f} s", active_Ohm,
                 std::max(0.1, left_s));
    }
}

double tip_stiffness_N_per_m(const session::Session &session, const Vector3 &along) {
    const control::Tuning &tuning = session.tuning().now();
    const servo::ServoSample &now = session.latest();
    const double K_DC = acting_K_DC_Nm_per_rad(session);
    const double share = 1.0 - now.eta;
    if (tuning.map == control::MotionMap::transpose) {
        return share * now.alpha_rad2_per_m2 * K_DC;
    }
    const device::PhantomGeometry &geometry = session.description().geometry;
    const Matrix3 J =
        device::motor_jacobian(geometry, device::joint_from_motor(geometry, now.theta_rad));
    return share * K_DC * (J.inverse() * along).squaredNorm();
}

void show_consequences(const session::Session &session) {
    control::Tuning tuning = session.tuning().now();
    tuning.dR_Ohm = active_dR_Ohm(session);
    const servo::ServoSample &now = session.latest();
    control::Coupling c = control::coupling(session.description().motor.front(), tuning,
                                            1.0 / session.servo().rate_hz(),
                                            session.device().device().delay_periods());
    // The rotors' added inertia as a mass at the tip, a mean over directions.
    const Matrix3 J_inverse =
        device::motor_jacobian(
            session.description().geometry,
            device::joint_from_motor(session.description().geometry, now.theta_rad))
            .inverse();
    const double added_mass_g = 1000.0 * c.added_inertia_kg_m2 * J_inverse.squaredNorm() / 3.0;
    c.K_DC_Nm_per_rad = acting_K_DC_Nm_per_rad(session);
    const double stiffness = control::tip_stiffness_N_per_m(c, now.alpha_rad2_per_m2, tuning.eta);

    if (!ImGui::BeginTable("consequences", 4, ImGuiTableFlags_SizingFixedFit)) {
        return;
    }
    show("K_L = K_HF", "{:.2f}", c.K_L_Nm_per_rad, "N·m/rad");
    show("K_DC", "{:.3f}", c.K_DC_Nm_per_rad, "N·m/rad");
    show("B_dR", "{:.2e}", c.B_dR_Nms_per_rad, "N·m·s/rad");
    show("lag τ", "{:.2f}", 1000.0 * c.loop_lag_s, "ms");
    show("added", "{:.1e}", c.added_inertia_kg_m2, "kg·m²");
    show("at the tip", "{:.0f}", added_mass_g, "g");
    show("tip stiffness", "{:.2f}", 1e-3 * stiffness, "N/mm");
    show("active α", "{:.0f}", now.alpha_rad2_per_m2, "rad²/m²");
    ImGui::EndTable();
    show_held_up_dR(session);
    if (tuning.map == control::MotionMap::transpose &&
        now.alpha_rad2_per_m2 > now.alpha_bound_rad2_per_m2 * (1.0 + 1e-9)) {
        ui::text(kDanger, "α is above its bound (29), {:.0f} rad²/m²", now.alpha_bound_rad2_per_m2);
        ui::explain("the gains of a motor exceed its tuning, so that its margin is smaller;\n"
                    "the loop's own stability limit lies higher");
    }
}

} // namespace springdrive::app
