#include "app/panels/tuning_consequences.h"

#include "app/panels/held_dR.h"
#include "app/plots/symbols.h"

#include "app/widgets/widgets.h"
#include "base/print.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/coupling.h"
#include "engine/control/tuning.h"

#include <Eigen/LU>

#include <array>

namespace springdrive::app {

namespace {

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

double tip_stiffness_N_per_m(const session::Session &session, const Vector3 &along) {
    control::Tuning tuning = session.tuning().now();
    tuning.dR_Ohm = active_dR_Ohm(session);
    const double K_DC = control::mean_static_stiffness_Nm_per_rad(session.description(), tuning);
    const servo::ServoSample &now = session.latest();
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
    c.K_DC_Nm_per_rad = control::mean_static_stiffness_Nm_per_rad(session.description(), tuning);
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
