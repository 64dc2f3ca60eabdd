#include "app/widgets/widgets.h"

#include "base/text.h"
#include "engine/record/telemetry_columns.h"

#include <imgui_stdlib.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <optional>
#include <string_view>
#include <type_traits>
#include <vector>

namespace springdrive::app {

void apply_look(float scale) {
    ImGuiStyle &style = ImGui::GetStyle();
    style = ImGuiStyle();
    ImGui::StyleColorsDark();
    style.WindowRounding = 0.0F;
    style.WindowBorderSize = 1.0F;
    style.FrameRounding = 4.0F;
    style.GrabRounding = 4.0F;
    style.GrabMinSize = 12.0F;
    style.ScrollbarSize = 9.0F;
    style.WindowPadding = ImVec2(10.0F, 8.0F);
    style.FramePadding = ImVec2(6.0F, 2.0F);
    style.ItemSpacing = ImVec2(7.0F, 4.0F);
    style.ScaleAllSizes(scale);

    ImVec4 *colours = style.Colors;
    colours[ImGuiCol_Text] = kInk;
    colours[ImGuiCol_WindowBg] = ImVec4(0.115F, 0.127F, 0.15F, 1.0F);
    colours[ImGuiCol_PopupBg] = ImVec4(0.14F, 0.155F, 0.18F, 1.0F);
    colours[ImGuiCol_Border] = ImVec4(0.24F, 0.27F, 0.31F, 1.0F);
    colours[ImGuiCol_TitleBg] = ImVec4(0.16F, 0.18F, 0.215F, 1.0F);
    colours[ImGuiCol_TitleBgActive] = colours[ImGuiCol_TitleBg];
    colours[ImGuiCol_FrameBg] = ImVec4(0.20F, 0.225F, 0.265F, 1.0F);
    colours[ImGuiCol_FrameBgHovered] = ImVec4(0.25F, 0.285F, 0.335F, 1.0F);
    colours[ImGuiCol_FrameBgActive] = ImVec4(0.28F, 0.32F, 0.38F, 1.0F);
    colours[ImGuiCol_SliderGrab] = ImVec4(0.33F, 0.62F, 0.93F, 1.0F);
    colours[ImGuiCol_SliderGrabActive] = ImVec4(0.47F, 0.74F, 1.0F, 1.0F);
    colours[ImGuiCol_Button] = ImVec4(0.22F, 0.29F, 0.38F, 1.0F);
    colours[ImGuiCol_ButtonHovered] = ImVec4(0.28F, 0.38F, 0.51F, 1.0F);
    colours[ImGuiCol_ButtonActive] = ImVec4(0.33F, 0.46F, 0.62F, 1.0F);
    colours[ImGuiCol_Header] = ImVec4(0.22F, 0.29F, 0.38F, 1.0F);
    colours[ImGuiCol_HeaderHovered] = ImVec4(0.28F, 0.38F, 0.51F, 1.0F);
    colours[ImGuiCol_CheckMark] = colours[ImGuiCol_SliderGrab];
}

namespace ui {

namespace {

struct State {
    WindowReport report;
    std::vector<std::string> scopes;
    bool is_disabled = false;
    std::size_t explained = 0; ///< tooltips of items so far
    ImVec2 hovered_row;        ///< corner of the row below the mouse
    double hovered_since_s = 0.0;
};

State &state() {
    static State the_one;
    return the_one;
}

/// The part of a label that names it in ids.
std::string_view name_of(std::string_view label) {
    const std::size_t marks = label.find("##");
    if (marks == std::string_view::npos) {
        return label;
    }
    return label.substr(std::min(label.find_first_not_of('#', marks), label.size()));
}

std::string_view text_of(std::string_view label) { return label.substr(0, label.find("##")); }

std::string id_of(std::string_view label) {
    std::string id;
    for (const std::string &scope : state().scopes) {
        id += scope + '/';
    }
    id += name_of(label);
    if (id.ends_with('/')) { // an item without a name of its own
        id.pop_back();
    }
    return id;
}

/// Whether the previous item is wider than its window.
bool overflows() {
    const float right = ImGui::GetWindowPos().x + ImGui::GetWindowWidth();
    return ImGui::GetItemRectMax().x > right + 0.5F;
}

/// Of the previous item, without what is scrolled out of its panel above or below.
Rectangle shown_place() {
    ImVec2 lower = ImGui::GetItemRectMin();
    ImVec2 upper = ImGui::GetItemRectMax();
    if (ImGui::GetScrollMaxY() > 0.0F && ImGui::IsItemVisible()) {
        const float top = ImGui::GetWindowPos().y;
        lower.y = std::max(lower.y, top);
        upper.y = std::min(upper.y, top + ImGui::GetWindowHeight());
    }
    return {lower, {upper.x - lower.x, upper.y - lower.y}};
}

void enter_item(std::string_view label, const char *kind, std::string_view text,
                decltype(ShownItem::value) value, decltype(ShownItem::numbers) numbers) {
    ShownItem item;
    item.id = id_of(label);
    item.kind = kind;
    item.text = text;
    item.value = std::move(value);
    item.numbers = std::move(numbers);
    item.place = shown_place();
    item.is_visible = ImGui::IsItemVisible();
    item.is_enabled = !state().is_disabled;
    item.is_focused = ImGui::IsItemFocused();
    item.overflows = overflows();
    state().report.enter(std::move(item));
}

/// With line ends in place of spaces, so that lines are of that width at most. ImGui itself also
/// breaks behind the point of a number.
std::string broken_at_spaces(std::string text, float width) {
    std::size_t begin = 0;            // of the line
    std::optional<std::size_t> space; // the last in it
    for (std::size_t i = 0; i <= text.size(); ++i) {
        if (i < text.size() && text[i] != ' ' && text[i] != '\n') {
            continue; // within a word
        }
        if (space && ImGui::CalcTextSize(text.data() + begin, text.data() + i).x > width) {
            text[*space] = '\n';
            begin = *space + 1;
        }
        space = i;
        if (i < text.size() && text[i] == '\n') {
            begin = i + 1;
            space.reset();
        }
    }
    return text;
}

/// At the mouse; long lines are broken.
void show_tooltip(std::string_view text) {
    ImGui::BeginTooltip();
    ImGui::PushTextWrapPos(44.0F * ImGui::GetFontSize());
    ImGui::TextUnformatted(text.data(), text.data() + text.size());
    ImGui::PopTextWrapPos();
    enter("", "tooltip", text);
    ImGui::EndTooltip();
}

} // namespace

WindowReport &report() { return state().report; }

void enter(std::string_view label, const char *kind, std::string_view text,
           decltype(ShownItem::value) value, decltype(ShownItem::numbers) numbers) {
    if (state().report.is_requested()) {
        enter_item(label, kind, text, std::move(value), std::move(numbers));
    }
}

void enter_at(const Rectangle &place, std::string_view label, const char *kind,
              std::string_view text) {
    if (state().report.is_requested()) {
        ShownItem item;
        item.id = id_of(label);
        item.kind = kind;
        item.text = text;
        item.place = place;
        state().report.enter(std::move(item));
    }
}

Scope::Scope(std::string_view name) {
    state().scopes.emplace_back(name_of(name));
    ImGui::PushID(name.data(), name.data() + name.size());
}

Scope::~Scope() {
    ImGui::PopID();
    state().scopes.pop_back();
}

Sized::Sized(ImFont *font, float height) {
    ImGui::PushFont(font);
    const float plain = font->FontSize * font->Scale * ImGui::GetIO().FontGlobalScale;
    ImGui::SetWindowFontScale(height / plain);
}

Sized::~Sized() {
    ImGui::SetWindowFontScale(1.0F);
    ImGui::PopFont();
}

Panel::Panel(const char *title, const Rectangle &place, ImGuiWindowFlags flags) : scope_(title) {
    ImGui::SetNextWindowPos(place.corner);
    ImGui::SetNextWindowSize(place.size);
    ImGui::Begin(title, nullptr,
                 flags | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize |
                     ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoSavedSettings);
    enter_at(place, "", "panel", title);
}

Panel::~Panel() { ImGui::End(); }

Tab::Tab(const char *label) : is_open_(ImGui::BeginTabItem(label)) {
    enter(label, "tab", text_of(label), is_open_);
    if (is_open_) {
        state().scopes.emplace_back(name_of(label));
    }
}

Tab::~Tab() {
    if (is_open_) {
        state().scopes.pop_back();
        ImGui::EndTabItem();
    }
}

Disabled::Disabled(bool is_disabled) : before_(state().is_disabled) {
    state().is_disabled = before_ || is_disabled;
    ImGui::BeginDisabled(is_disabled);
}

Disabled::~Disabled() {
    ImGui::EndDisabled();
    state().is_disabled = before_;
}

void show_text(const ImVec4 &colour, const std::string &text, bool wraps) {
    ImGui::PushStyleColor(ImGuiCol_Text, colour);
    if (wraps) {
        const std::string lines = broken_at_spaces(text, ImGui::GetContentRegionAvail().x);
        ImGui::PushTextWrapPos(0.0F); // for a word that is too long
        ImGui::TextUnformatted(lines.data(), lines.data() + lines.size());
        ImGui::PopTextWrapPos();
    } else {
        ImGui::TextUnformatted(text.data(), text.data() + text.size());
    }
    ImGui::PopStyleColor();
    enter("", "text", text);
}

void explain(std::string_view text) {
    if (ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled)) {
        ++state().explained;
        show_tooltip(text);
    }
}

ExplainedRow::ExplainedRow(std::string text, Reach reach)
    : text_(std::move(text)), reach_(reach), corner_(ImGui::GetCursorScreenPos()),
      explained_before_(state().explained) {}

ExplainedRow::~ExplainedRow() {
    constexpr double kRest_s = 0.4; // a mouse that passes raises nothing
    const float gap = 0.5F * ImGui::GetStyle().ItemSpacing.y;
    const float right = reach_ == Reach::items
                            ? ImGui::GetItemRectMax().x
                            : ImGui::GetWindowPos().x + ImGui::GetWindowContentRegionMax().x;
    const float bottom = reach_ == Reach::items ? ImGui::GetItemRectMax().y
                                                : ImGui::GetCursorScreenPos().y - 2.0F * gap;
    const bool is_over =
        ImGui::IsWindowHovered() &&
        ImGui::IsMouseHoveringRect({corner_.x, corner_.y - gap}, {right, bottom + gap});
    if (!is_over || ImGui::IsAnyItemActive() || state().explained != explained_before_) {
        return;
    }
    if (state().hovered_row.x != corner_.x || state().hovered_row.y != corner_.y) {
        state().hovered_row = corner_;
        state().hovered_since_s = ImGui::GetTime();
    }
    if (ImGui::GetTime() - state().hovered_since_s < kRest_s) {
        return;
    }
    show_tooltip(text_);
}

bool button(const char *label, ImVec2 size) {
    const bool is_pressed = ImGui::Button(label, size);
    enter(label, "button", text_of(label));
    return is_pressed;
}

bool tab_button(const char *label) {
    const bool is_pressed = ImGui::TabItemButton(label, ImGuiTabItemFlags_Trailing);
    enter(label, "button", text_of(label));
    return is_pressed;
}

bool small_button(const char *label) {
    const bool is_pressed = ImGui::SmallButton(label);
    enter(label, "button", text_of(label));
    return is_pressed;
}

bool checkbox(const char *label, bool &value) {
    const bool is_changed = ImGui::Checkbox(label, &value);
    enter(label, "checkbox", text_of(label), value);
    return is_changed;
}

bool slider(const char *label, double &value, double minimum, double maximum, bool is_logarithmic) {
    const bool is_changed = ImGui::SliderScalar(
        label, ImGuiDataType_Double, &value, &minimum, &maximum, "",
        ImGuiSliderFlags_NoInput | (is_logarithmic ? ImGuiSliderFlags_Logarithmic : 0));
    enter(label, "slider", "", value);
    return is_changed;
}

bool text_field(const char *label, const char *hint, std::string &text) {
    const bool is_entered =
        ImGui::InputTextWithHint(label, hint, &text, ImGuiInputTextFlags_EnterReturnsTrue);
    enter(label, "field", text_of(label), text);
    return is_entered;
}

bool text_box(const char *label, std::string &text, ImVec2 size) {
    const bool is_changed = ImGui::InputTextMultiline(label, &text, size);
    enter(label, "field", text_of(label), text);
    return is_changed;
}

bool selectable(const char *label, bool is_selected) {
    const bool is_clicked = ImGui::Selectable(label, is_selected);
    enter(label, "entry", text_of(label), is_selected);
    return is_clicked;
}

DropDown::DropDown(const char *label, const char *shown) {
    // Taken before: while the list is open, ImGui's previous item is the list.
    const Rectangle place{ImGui::GetCursorScreenPos(),
                          {ImGui::CalcItemWidth(), ImGui::GetFrameHeight()}};
    enter_at(place, label, "choice", shown);
    is_open_ = ImGui::BeginCombo(label, shown);
    if (is_open_) {
        state().scopes.emplace_back(name_of(label));
    } else if (state().report.is_requested() && ImGui::IsItemFocused()) {
        state().report.note_focus();
    }
}

DropDown::~DropDown() {
    if (is_open_) {
        state().scopes.pop_back();
        ImGui::EndCombo();
    }
}

bool choice(const char *label, std::size_t &index, std::span<const char *const> labels) {
    const DropDown list(label, index < labels.size() ? labels[index] : "");
    bool is_changed = false;
    for (std::size_t i = 0; list && i < labels.size(); ++i) {
        if (selectable(labels[i], i == index)) {
            is_changed = i != index;
            index = i;
        }
    }
    return is_changed;
}

void progress(const char *label, double share, const std::string &text) {
    ImGui::ProgressBar(static_cast<float>(share), ImVec2(-1.0F, 0.0F), text.c_str());
    enter(label, "progress", text, share);
}

} // namespace ui

namespace {

using nlohmann::json;

json json_of(const ShownItem &item) {
    json shown{{"id", item.id},
               {"kind", item.kind},
               {"text", item.text},
               {"x", item.place.corner.x},
               {"y", item.place.corner.y},
               {"width", item.place.size.x},
               {"height", item.place.size.y}};
    std::visit(
        [&shown](const auto &value) {
            if constexpr (!std::is_same_v<std::decay_t<decltype(value)>, std::monostate>) {
                shown["value"] = value;
            }
        },
        item.value);
    for (const auto &[name, number] : item.numbers) {
        shown["numbers"][name] = number;
    }
    // Only what is out of the ordinary.
    if (!item.is_visible) {
        shown["visible"] = false;
    }
    if (!item.is_enabled) {
        shown["enabled"] = false;
    }
    if (item.is_focused) {
        shown["focused"] = true;
    }
    if (item.overflows) {
        shown["overflows"] = true;
    }
    return shown;
}

/// Enums as numbers, as in exported records.
template <typename Value> json number_of(const Value &value) {
    if constexpr (std::is_enum_v<Value>) {
        return static_cast<int>(value);
    } else {
        return value;
    }
}

json json_of(const servo::ServoSample &sample) {
    json columns = json::object();
    record::for_each_column(sample,
                            [&columns](std::string_view name, std::string_view, const auto &value) {
                                columns[std::string(name)] = number_of(value);
                            });
    return columns;
}

} // namespace

WindowFacts facts_of(std::uint64_t frame, int width, int height, float scale,
                     const servo::DurationHistogram &durations) {
    return {frame, static_cast<float>(width), static_cast<float>(height),
            scale, durations.quantile_s(0.5), durations.quantile_s(0.99)};
}

std::string json_line(const WindowReport &report, const WindowFacts &window,
                      const servo::ServoSample &sample) {
    json items = json::array();
    for (const ShownItem &item : report.items()) {
        items.push_back(json_of(item));
    }
    const json all{{"window",
                    {{"frame", window.frame},
                     {"width", window.width},
                     {"height", window.height},
                     {"scale", window.scale},
                     {"frame_median_s", window.frame_median_s},
                     {"frame_p99_s", window.frame_p99_s}}},
                   {"items", std::move(items)},
                   {"sample", json_of(sample)}};
    return json_text(all, -1);
}

} // namespace springdrive::app
