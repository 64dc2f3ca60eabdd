#include "app/panels/panels.h"
#include "app/widgets/widgets.h"
#include "base/degrees.h"
#include "engine/session/telemetry_history.h"

#include <algorithm>
#include <array>
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

struct ReadOut {
    const char *name;
    std::string label;
    double value = 0.0;
    int decimals = 0;
    const char *unit;
    ImVec4 colour;
};

/// Digits, 0.626 of that, are 5 % of the view's height where its width allows.
float height_of_values(const Rectangle &view) {
    return std::min(0.08F * view.size.y, 0.06F * view.size.x);
}

/// The value large, below it what it is.
void show_read_out(const ReadOut &shown, ImFont *font, float digits_height) {
    const ui::Scope scope(shown.name);
    ImGui::TableNextColumn();
    {
        const ui::Sized sized(font, digits_height);
        ui::text(shown.colour, "{}",
                 std::isnan(shown.value)
                     ? "–"
                     : ui::formatted("{:.{}f}{}", shown.value, shown.decimals, shown.unit));
    }
    ui::text(kInk, "{}", shown.label);
}

} // namespace

float height_of_read_outs(const Rectangle &view) {
    const ImGuiStyle &style = ImGui::GetStyle();
    return height_of_values(view) + ImGui::GetTextLineHeight() + style.ItemSpacing.y +
           2.0F * (style.WindowPadding.y + style.CellPadding.y);
}

void draw_read_outs(const PlotSubject &subject, control::MotionMap map, const Rectangle &view,
                    const Window::LargeText &text, float scale) {
    const float margin = 10.0F * scale;
    const ui::Scope scope("read-outs");
    ImGui::SetNextWindowPos({view.corner.x + margin, view.corner.y + view.size.y - 3.0F * margin},
                            ImGuiCond_Always, {0.0F, 1.0F});
    ImGui::PushStyleColor(ImGuiCol_WindowBg, ImVec4(0.10F, 0.11F, 0.13F, 0.92F));
    ImGui::Begin("read-outs", nullptr,
                 ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoInputs |
                     ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings |
                     ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_AlwaysAutoResize);
    const bool transposes = map == control::MotionMap::transpose;
    const std::array<ReadOut, 3> shown{{
        {"force", "force", shown_value(subject, "force_N"), 2, " N", kForce},
        {"angle", ui::formatted("off the normal, {}", control::label_of(map)),
         kDegreesPerRadian *
             shown_value(subject, transposes ? "transpose_measured_rad" : "inverse_measured_rad"),
         0, "°", transposes ? kTransposeMap : kInverseMap},
        {"depth", "depth", 1e3 * shown_value(subject, "penetration_m"), 1, " mm", kInk},
    }};
    const float height = height_of_values(view);
    constexpr float kWidth = 4.0F; // of "12.34 mm", by its height
    if (ImGui::BeginTable("values", static_cast<int>(shown.size()),
                          ImGuiTableFlags_SizingFixedFit)) {
        for (const ReadOut &each : shown) { // as wide as the widest value, so that none moves
            ImGui::TableSetupColumn(
                each.name, ImGuiTableColumnFlags_WidthFixed,
                std::max(kWidth * height, ImGui::CalcTextSize(each.label.c_str()).x));
        }
        for (const ReadOut &each : shown) {
            show_read_out(each, text.large, height);
        }
        ImGui::EndTable();
    }
    ImGui::End();
    ImGui::PopStyleColor();
}

} // namespace springdrive::app
