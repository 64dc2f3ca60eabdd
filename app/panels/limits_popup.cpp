#include "app/panels/panels.h"
#include "app/widgets/widgets.h"

#include <cmath>

namespace springdrive::app {

namespace {

constexpr double kMinShare = 0.02; // of the device's limit; lower values always trip

/// A slider from nearly zero to the device's limit, and a button to restore that.
bool edit_limit(const servo::SafetyLimit &limit, double device_value, double &requested) {
    const double scale = limit.shown_per_si;
    const float font = ImGui::GetFontSize();
    double shown = scale * std::min(device_value, requested);
    const double maximum = scale * device_value;
    const double minimum = kMinShare * maximum;
    const ui::Scope scope(limit.name);
    ImGui::AlignTextToFramePadding();
    ui::text(kFaintInk, "{}", limit.what);
    ImGui::SameLine(12.0F * font);
    ImGui::SetNextItemWidth(10.0F * font);
    bool changed = ui::slider_with_number("##slider", shown, minimum, maximum, "%.3g");
    ImGui::SameLine();
    ui::text(kFaintInk, "{}", limit.unit);
    ImGui::SameLine(24.5F * font);
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

void draw_limits_popup(session::Session &session) {
    if (!ImGui::BeginPopup("limits")) {
        return;
    }
    const ui::Scope scope("limits");
    ui::text(kInk, "Limits at which the device is stopped");
    const servo::SafetyLimits device = servo::limits_of(session.description());
    servo::SafetyLimits requested = session.servo().inputs().limits;
    bool changed = false;
    for (const servo::SafetyLimit &limit : servo::kSafetyLimits) {
        changed |= edit_limit(limit, device.*limit.value, requested.*limit.value);
    }
    if (changed) {
        session.servo().lower_limits(requested);
    }
    ui::text(kFaintInk, "Set by the device file; can only be lowered here.");
    ImGui::EndPopup();
}

} // namespace springdrive::app
