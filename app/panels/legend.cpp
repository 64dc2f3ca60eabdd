#include "app/panels/panels.h"

#include "app/widgets/widgets.h"
#include "base/degrees.h"
#include "base/eigenvalues.h"

#include <string>

namespace springdrive::app {

namespace {

ImU32 ink_of(const Colour &colour) {
    return ImGui::ColorConvertFloat4ToU32({colour[0], colour[1], colour[2], 1.0F});
}

/// One colour, two halves, or a scale.
void draw_swatch(const OverlayStyle &look) {
    const float height = ImGui::GetTextLineHeight();
    const ImVec2 size{1.8F * height, 0.62F * height};
    const ImVec2 place = ImGui::GetCursorScreenPos();
    const ImVec2 corner{place.x, place.y + 0.5F * (ImGui::GetFrameHeight() - size.y)};
    ImDrawList &list = *ImGui::GetWindowDrawList();
    constexpr int kParts = 6;
    for (int part = 0; part < kParts; ++part) {
        const auto at = [&](int edge) {
            return corner.x + size.x * static_cast<float>(edge) / static_cast<float>(kParts);
        };
        const auto share = [](int edge) { return static_cast<double>(edge) / kParts; };
        const Colour plain = part < kParts / 2 ? look.colour : look.second;
        const ImU32 left = ink_of(look.is_scale ? scale_colour(share(part)) : plain);
        const ImU32 right = ink_of(look.is_scale ? scale_colour(share(part + 1)) : plain);
        list.AddRectFilledMultiColor({at(part), corner.y}, {at(part + 1), corner.y + size.y}, left,
                                     right, right, left);
    }
    ImGui::Dummy({size.x, ImGui::GetFrameHeight()});
}

/// The numbers behind the colours, if there are any.
std::string range_of(Thing thing, const TouchValues &values) {
    constexpr double kPerMillimetre = 1e-3;
    switch (thing) {
    case Thing::trace:
        return ui::formatted("0 … {:.0f} N", kTraceEnd_N);
    case Thing::direction_errors:
        return !values.workspace
                   ? ""
                   : ui::formatted("0 … {:.0f}°", kDegreesPerRadian * values.workspace->largest);
    case Thing::stiffnesses:
        return !values.workspace
                   ? ""
                   : ui::formatted("0 … {:.1f} N/mm", kPerMillimetre * values.workspace->largest);
    case Thing::stiffness:
        if (values.inverse_stiffness_N_per_m && values.transpose_stiffness_N_per_m) {
            const Vector3 along_axes = symmetric_eigenvalues(*values.inverse_stiffness_N_per_m);
            return ui::formatted("{:.2f} · {:.2f} … {:.2f} N/mm",
                                 kPerMillimetre * *values.transpose_stiffness_N_per_m,
                                 kPerMillimetre * along_axes[0], kPerMillimetre * along_axes[2]);
        }
        return "";
    default:
        return "";
    }
}

void draw_row(ShownThings &shown, const OverlayStyle &look, const TouchValues &values) {
    draw_swatch(look);
    ImGui::SameLine();
    bool is_on = shown.shows(look.thing);
    if (ui::checkbox(look.label, is_on)) {
        shown.show(look.thing, is_on);
    }
    ui::explain(look.help);
    if (const std::string range = is_on ? range_of(look.thing, values) : ""; !range.empty()) {
        const ui::Scope scope(look.word);
        ImGui::Indent(2.6F * ImGui::GetTextLineHeight());
        ui::text(kFaintInk, "{}", range);
        ImGui::Unindent(2.6F * ImGui::GetTextLineHeight());
    }
}

} // namespace

float draw_legend(ShownThings &shown, bool &is_open, const TouchValues &values,
                  const Rectangle &view, float top, float width, float scale) {
    const float margin = 10.0F * scale;
    const ui::Scope scope("legend");
    ImGui::SetNextWindowPos({view.end().x - margin, top}, ImGuiCond_Always, {1.0F, 0.0F});
    ImGui::PushStyleVar(ImGuiStyleVar_WindowBorderSize, 0.0F);
    ImGui::PushStyleColor(ImGuiCol_WindowBg, ImVec4(0.07F, 0.08F, 0.10F, 0.92F));
    const ImVec2 padding = ImGui::GetStyle().WindowPadding;
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, is_open ? padding : ImVec2(0.0F, 0.0F));
    ImGui::Begin("legend", nullptr,
                 ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                     ImGuiWindowFlags_NoScrollbar | ImGuiWindowFlags_NoSavedSettings |
                     ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_AlwaysAutoResize |
                     (is_open ? 0 : ImGuiWindowFlags_NoBackground));
    if (!is_open) {
        is_open = ui::button("legend", {width, 0.0F});
        ui::explain("Names what is drawn in the scene, and switches it.");
    } else {
        ui::text(kForce, "what is drawn");
        ImGui::SameLine(12.0F * ImGui::GetFontSize());
        is_open = !ui::small_button("×##fold");
        ui::explain("Folds the legend; what is switched on stays.");
        ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing,
                            {ImGui::GetStyle().ItemSpacing.x, 1.0F * scale});
        ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, {2.0F * scale, 1.0F * scale});
        for (const OverlayStyle &look : kThings) {
            draw_row(shown, look, values);
        }
        ImGui::PopStyleVar(2);
    }
    const float card_width = is_open ? ImGui::GetWindowWidth() : 0.0F;
    ImGui::End();
    ImGui::PopStyleVar(2);
    ImGui::PopStyleColor();
    return card_width;
}

} // namespace springdrive::app
