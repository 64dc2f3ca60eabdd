#include "app/panels/panels.h"
#include "app/widgets/widgets.h"
#include "base/degrees.h"
#include "engine/session/telemetry_history.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace springdrive::app {

namespace {

/// The value of a channel where the record stands, or now; NaN where it has none.
double shown_value(const PlotSubject &subject, const char *channel) {
    const record::ChannelStore &store = subject.store;
    if (store.is_empty()) {
        return std::nan("");
    }
    const std::uint64_t last = store.end() - 1;
    const std::uint64_t row =
        subject.position_s ? std::min(last, store.row_at(*subject.position_s)) : last;
    return store.value(session::channel_named(channel).value(), row);
}

void show_read_out(const char *label, double value, int decimals, const char *unit) {
    const ui::Scope scope(label);
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    ui::text(kFaintInk, "{}", label);
    ImGui::TableNextColumn();
    ui::text(kInk, "{}",
             std::isnan(value) ? "–" : ui::formatted("{:.{}f}{}", value, decimals, unit));
}

} // namespace

void draw_read_outs(const PlotSubject &subject, control::MotionMap map, const Rectangle &view,
                    float scale) {
    const float margin = 10.0F * scale;
    const ui::Scope scope("read-outs");
    ImGui::SetNextWindowPos({view.corner.x + margin, view.corner.y + view.size.y - 3.0F * margin},
                            ImGuiCond_Always, {0.0F, 1.0F});
    ImGui::PushStyleColor(ImGuiCol_WindowBg, ImVec4(0.10F, 0.11F, 0.13F, 0.92F));
    ImGui::Begin("read-outs", nullptr,
                 ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoInputs |
                     ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings |
                     ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_AlwaysAutoResize);
    // As large as a third of the width allows.
    ImGui::SetWindowFontScale(std::clamp(view.size.x / (500.0F * scale), 1.1F, 1.6F));
    const bool transposes = map == control::MotionMap::transpose;
    if (ImGui::BeginTable("values", 2, ImGuiTableFlags_SizingFixedFit)) {
        show_read_out("force", shown_value(subject, "force_N"), 2, " N");
        show_read_out("off the normal",
                      kDegreesPerRadian * shown_value(subject, transposes ? "transpose_measured_rad"
                                                                          : "inverse_measured_rad"),
                      0, "°");
        show_read_out("depth", 1e3 * shown_value(subject, "penetration_m"), 1, " mm");
        ImGui::EndTable();
    }
    ui::text(transposes ? kTransposeMap : kInverseMap, "{}", control::label_of(map));
    ImGui::End();
    ImGui::PopStyleColor();
}

} // namespace springdrive::app
