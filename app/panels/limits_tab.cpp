#include "app/panels/panels.h"
#include "app/plots/symbols.h"
#include "app/widgets/widgets.h"
#include "device/core/phantom/kinematics.h"
#include "engine/servo/workspace_edge.h"

#include <algorithm>
#include <cmath>

namespace springdrive::app {

namespace {

constexpr double kMinShare = 0.02; // of the device's limit; lower values always trip

/// The value that is held against a limit, in its SI unit; NaN where the window does not know it.
double live_value(const session::Session &session, double servo::SafetyLimits::*limit) {
    using servo::SafetyLimits;
    const servo::ServoSample &now = session.latest();
    if (limit == &SafetyLimits::voltage_V) {
        return now.command.e_W_V.cwiseAbs().maxCoeff();
    }
    if (limit == &SafetyLimits::current_A) {
        return now.current_A.cwiseAbs().maxCoeff();
    }
    if (limit == &SafetyLimits::winding_C) {
        return std::max({now.winding[0].max_C, now.winding[1].max_C, now.winding[2].max_C});
    }
    if (limit == &SafetyLimits::tip_force_N) {
        return now.tip_force_N.norm();
    }
    const device::DeviceDescription &device = session.description();
    const Vector3 q_rad = device::joint_from_motor(device.geometry, now.theta_rad);
    if (limit == &SafetyLimits::tip_speed_m_per_s) {
        return (device::motor_jacobian(device.geometry, q_rad) * now.theta_rate_rad_per_s).norm();
    }
    if (limit == &SafetyLimits::beyond_stops_rad) {
        return servo::beyond_limits(device.joint_limits, q_rad, 0.0).max_excess_rad();
    }
    if (limit == &SafetyLimits::generated_energy_J) {
        return now.generated_energy_J;
    }
    if (limit == &SafetyLimits::late_s) {
        return now.missed_in_a_row * session.servo().period_s();
    }
    return std::nan("");
}

/// A slider from nearly zero to the device's limit, and a button to restore that.
bool edit_limit(const servo::SafetyLimit &limit, double device_value, double live,
                double &requested) {
    const double scale = limit.shown_per_si;
    const float font = ImGui::GetFontSize();
    double shown = scale * std::min(device_value, requested);
    const double maximum = scale * device_value;
    const double minimum = kMinShare * maximum;
    const ui::Scope scope(limit.name);
    const ui::ExplainedRow row(explanation_of(std::string("limit_") + limit.name));
    ImGui::AlignTextToFramePadding();
    ui::text(kFaintInk, "{}", limit.what);
    ImGui::SameLine(10.6F * font);
    ImGui::AlignTextToFramePadding();
    if (std::isnan(live)) {
        ui::text(kFaintInk, "–");
    } else {
        // Orange from where the force is held back on.
        const double digits = scale * live < 1e-3 * maximum ? 0.0 : scale * live;
        ui::text(digits > 0.9 * shown ? kWarning : kInk, "{:.3g}", digits);
    }
    ImGui::SameLine(13.6F * font);
    ImGui::SetNextItemWidth(6.6F * font);
    bool changed = ui::slider_with_number("##slider", shown, minimum, maximum, "%.3g");
    ImGui::SameLine();
    ui::text(kFaintInk, "{}", limit.unit);
    ImGui::SameLine(23.0F * font);
    if (ui::button("\u21BA##reset")) {
        shown = maximum;
        changed = true;
    }
    ui::explain(ui::formatted("reset to the device's limit, {:.3g} {}", maximum, limit.unit));
    if (changed) {
        requested = shown >= maximum ? device_value : shown / scale;
    }
    return changed;
}

} // namespace

void draw_limits_tab(session::Session &session) {
    const servo::SafetyLimits device = servo::limits_of(session.description());
    servo::SafetyLimits requested = session.servo().inputs().limits;
    bool changed = false;
    for (const servo::SafetyLimit &limit : servo::kSafetyLimits) {
        changed |= edit_limit(limit, device.*limit.value, live_value(session, limit.value),
                              requested.*limit.value);
    }
    if (changed) {
        session.servo().lower_limits(requested);
    }
    ui::wrapped(kFaintInk,
                "Now, and the limit: set by the device file, it can only be lowered here.");
}

} // namespace springdrive::app
