// Numbers to be typed: in a field, or on a slider after a click with Ctrl.
#include "app/widgets/widgets.h"
#include "base/text.h"

#include <imgui_internal.h>
#include <imgui_stdlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace springdrive::app::ui {

namespace {

/// The field in which a number is being typed: there is at most one.
struct Typing {
    ImGuiID id = 0;
    int frame = -2; ///< the last in which it was
    std::string text;
};

/// Why a number was not set; shown below its field until the next click or typing.
struct Refusal {
    ImGuiID id = 0;
    int frame = -2; ///< the last in which it was shown
    std::string text;
};

struct Entry {
    Typing typing;
    Refusal refusal;
    int typed_in = -2; ///< frame
};

Entry &entry() {
    static Entry the_one;
    return the_one;
}

/// The whole text as a number; its comma is a decimal point, as on many keyboards.
std::optional<double> typed_number(const std::string &typed) {
    std::string text = one_line(typed, typed.size());
    std::ranges::replace(text, ',', '.');
    const std::optional<double> number = number_in<double>(text);
    return number && std::isfinite(*number) ? number : std::nullopt;
}

/// Without what the format has around the number.
std::string text_of(double value, const char *format) {
    std::array<char, 64> number{};
    std::array<char, 64> shown{};
    ImGui::DataTypeFormatString(shown.data(), static_cast<int>(shown.size()), ImGuiDataType_Double,
                                &value,
                                ImParseFormatTrimDecorations(format, number.data(), number.size()));
    return shown.data();
}

/// Empty if it is in the range.
std::string error_of(const std::optional<double> &number, const std::string &typed,
                     const NumberRange &range) {
    if (number && *number >= range.minimum && *number <= range.maximum) {
        return {};
    }
    const std::string bounds = formatted("{:g} to {:g}{}{}", range.minimum, range.maximum,
                                         range.unit.empty() ? "" : " ", range.unit);
    const std::string name = std::string(range.name) + (range.name.empty() ? "" : " ");
    if (number) {
        return formatted("{}{:g} is out of range, {}: not set", name, *number, bounds);
    }
    return formatted("{}{} is no number{}: not set", name, in_quotes(typed),
                     std::isfinite(range.minimum) ? " from " + bounds : "");
}

/// Of the previous item.
void show_refusal(ImGuiID id) {
    Refusal &refusal = entry().refusal;
    const int frame = ImGui::GetFrameCount();
    if (refusal.id != id) {
        return;
    }
    const bool is_shown = refusal.frame == frame - 1 && !ImGui::IsMouseClicked(0);
    if (!is_shown && refusal.frame != frame) {
        refusal = {};
        return;
    }
    refusal.frame = frame;
    const ImVec2 padding = ImGui::GetStyle().FramePadding;
    const ImVec2 text = ImGui::CalcTextSize(refusal.text.c_str());
    const ImVec2 size{text.x + 2.0F * padding.x, text.y + 2.0F * padding.y};
    const ImVec2 room = ImGui::GetIO().DisplaySize;
    const ImVec2 corner{std::max(0.0F, std::min(ImGui::GetItemRectMin().x, room.x - size.x)),
                        std::min(ImGui::GetItemRectMax().y, room.y - size.y)};
    const ImVec2 end{corner.x + size.x, corner.y + size.y};
    ImDrawList &list = *ImGui::GetForegroundDrawList();
    list.AddRectFilled(corner, end, ImGui::GetColorU32(ImGuiCol_PopupBg, 1.0F));
    list.AddRect(corner, end, ImGui::ColorConvertFloat4ToU32(kDanger));
    list.AddText({corner.x + padding.x, corner.y + padding.y},
                 ImGui::ColorConvertFloat4ToU32(kDanger), refusal.text.c_str());
    enter_at({corner, size}, "", "error", refusal.text);
}

bool is_typed_in(ImGuiID id) {
    return entry().typing.id == id && entry().typing.frame == ImGui::GetFrameCount() - 1;
}

/// True when `value` was set.
bool type_number(const char *label, double &value, const char *format, const NumberRange &range) {
    const ImGuiID id = ImGui::GetID(label);
    Typing &typing = entry().typing;
    const bool was_typed_in = is_typed_in(id);
    std::string text = was_typed_in                   ? typing.text
                       : ImGui::TempInputIsActive(id) ? ImGui::GetInputTextState(id)->TextA.Data
                                                      : text_of(value, format);
    ImGui::InputText(label, &text, ImGuiInputTextFlags_AutoSelectAll);
    if (ImGui::IsItemActive()) {
        typing = {id, ImGui::GetFrameCount(), text};
        entry().refusal = {};
        return false;
    }
    const bool is_left = ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Escape));
    if (!was_typed_in || is_left || text.empty() || !ImGui::IsItemDeactivatedAfterEdit()) {
        return false;
    }
    const std::optional<double> number = typed_number(text);
    if (std::string error = error_of(number, text, range); !error.empty()) {
        entry().refusal = {id, ImGui::GetFrameCount(), std::move(error)};
        return false;
    }
    value = *number;
    return true;
}

/// After the previous item, which is a field for a number, or a slider with one.
void note_number(ImGuiID id) {
    if (ImGui::IsItemActive() && ImGui::GetIO().WantTextInput) {
        entry().typed_in = ImGui::GetFrameCount();
    }
    show_refusal(id);
}

} // namespace

bool types_number() { return entry().typed_in >= ImGui::GetFrameCount() - 1; }

bool slider_with_number(const char *label, double &value, double minimum, double maximum,
                        const char *format) {
    const ImGuiID id = ImGui::GetID(label);
    const bool is_typed = is_typed_in(id) || ImGui::TempInputIsActive(id);
    const bool is_changed =
        is_typed ? type_number(label, value, format, {"", minimum, maximum, ""})
                 : ImGui::SliderScalar(label, ImGuiDataType_Double, &value, &minimum, &maximum,
                                       format, ImGuiSliderFlags_AlwaysClamp);
    const std::string_view whole = label;
    enter(label, "slider", whole.substr(0, whole.find("##")), value);
    note_number(id);
    return is_changed;
}

bool number_field(const char *label, double &value, const char *format, const NumberRange &range) {
    const ImGuiID id = ImGui::GetID(label);
    const bool is_set = type_number(label, value, format, range);
    const bool is_typed = entry().typing.id == id && ImGui::IsItemActive();
    enter(label, "number", is_typed ? entry().typing.text : text_of(value, format), value);
    note_number(id);
    return is_set;
}

} // namespace springdrive::app::ui
