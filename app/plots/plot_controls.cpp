// The mouse and the menus of the plots: what PlotPanel lets its user choose.
#include "app/plots/channels.h"
#include "app/plots/plot_panel.h"
#include "app/widgets/widgets.h"
#include "base/degrees.h"
#include "engine/session/telemetry_history.h"

#include <fmt/core.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <iterator>
#include <limits>
#include <sstream>

namespace springdrive::app {

namespace {

constexpr float kGrip = 6.0F; ///< distance from which a cursor is taken, at scale 1

/// Sets what a plot shows; the time of all plots if it is one over time.
void show(Plot &plot, PlotPanelState &state, const PlotSource &source,
          const record::ChannelStore &live, const Axis &x, const std::optional<Axis> &y) {
    if (plot.settings.kind == PlotKind::time) {
        state.view.show(live, {x.from + source.zero_s, x.to + source.zero_s});
    } else {
        plot.settings.x = x;
    }
    if (y) {
        plot.settings.y = y;
    }
}

void zoom_by_wheel(Plot &plot, PlotPanelState &state, const PlotSource &source,
                   const record::ChannelStore &live) {
    const ImGuiIO &io = ImGui::GetIO();
    if (io.MouseWheel == 0.0F) {
        return;
    }
    const double factor = std::pow(0.8, io.MouseWheel);
    const PlotArea &area = plot.area;
    if (plot.settings.kind == PlotKind::polar) {
        plot.settings.y = area.y.zoomed(0.5, factor); // about its middle, the radius 0
    } else if (io.KeyCtrl) {
        const double share = area.y.share(area.y_at(io.MousePos.y));
        plot.settings.y = area.y.zoomed(share, factor);
    } else {
        const double share = area.x.share(area.x_at(io.MousePos.x));
        show(plot, state, source, live, area.x.zoomed(share, factor), std::nullopt);
    }
}

void pan(Plot &plot, PlotPanelState &state, const PlotSource &source,
         const record::ChannelStore &live) {
    const ImVec2 by = ImGui::GetIO().MouseDelta;
    if (by.x == 0.0F && by.y == 0.0F) {
        return;
    }
    const PlotArea &area = plot.area;
    std::optional<Axis> y;
    if (plot.settings.y) { // a range that the plot chose itself stays its own
        y = area.y.moved(by.y / area.where.size.y);
    }
    show(plot, state, source, live, area.x.moved(-by.x / area.where.size.x), y);
}

/// A range drawn with the right button becomes the whole plot.
void draw_box(Plot &plot, PlotPanelState &state, const PlotSource &source,
              const record::ChannelStore &live) {
    const ImVec2 mouse = ImGui::GetIO().MousePos;
    if (ImGui::IsItemHovered() && ImGui::IsMouseClicked(ImGuiMouseButton_Right)) {
        plot.box_from = mouse;
    }
    if (!plot.box_from) {
        return;
    }
    const ImVec2 from = *plot.box_from;
    ImGui::GetWindowDrawList()->AddRect(from, mouse, IM_COL32(230, 235, 240, 200));
    if (ImGui::IsMouseDown(ImGuiMouseButton_Right)) {
        return;
    }
    plot.box_from.reset();
    if (std::abs(mouse.x - from.x) > kGrip && std::abs(mouse.y - from.y) > kGrip) {
        const PlotArea &area = plot.area;
        Axis x = area.x;
        Axis y = area.y;
        x.from = area.x_at(std::min(from.x, mouse.x));
        x.to = area.x_at(std::max(from.x, mouse.x));
        y.from = area.y_at(std::max(from.y, mouse.y));
        y.to = area.y_at(std::min(from.y, mouse.y));
        show(plot, state, source, live, x, y);
    }
}

std::optional<std::size_t> cursor_under_mouse(const Plot &plot, const PlotPanelState &state,
                                              double zero_s) {
    if (!state.view.shows_cursors || plot.settings.kind != PlotKind::time) {
        return std::nullopt;
    }
    for (std::size_t i = 0; i < 2; ++i) {
        const float x = plot.area.place_x(state.view.cursor_s[i] - zero_s);
        if (std::abs(x - ImGui::GetIO().MousePos.x) < kGrip * text_height() / 15.0F) {
            return i;
        }
    }
    return std::nullopt;
}

std::string values_text(const Plot &plot, const PlotSource &source) {
    const double time_s = plot.area.x_at(ImGui::GetIO().MousePos.x) + source.zero_s;
    const record::ChannelStore &store = source.store;
    const std::optional<std::uint64_t> row = store.row_shown_at(time_s);
    if (!row) {
        return "";
    }
    std::string text = fmt::format("{:.4f} s", store.time_s(*row));
    for (const std::size_t channel : plot.settings.channels) {
        const ShownUnit unit = shown_unit(channel, plot.settings.in_si);
        const double value = store.value(channel, *row) * unit.per_si;
        text += std::isnan(value)
                    ? fmt::format("\n{}: –", look_of(channel).label)
                    : fmt::format("\n{}: {:.4g} {}", look_of(channel).label, value, unit.name);
    }
    return text;
}

void read_values(const Plot &plot, const PlotPanelState &state, const PlotSource &source) {
    const ImVec2 mouse = ImGui::GetIO().MousePos;
    if (!plot.area.where.contains(mouse)) {
        return;
    }
    std::string text;
    switch (plot.settings.kind) {
    case PlotKind::time:
        text = values_text(plot, source);
        ImGui::GetWindowDrawList()->AddLine({mouse.x, plot.area.where.corner.y},
                                            {mouse.x, plot.area.where.end().y},
                                            IM_COL32(200, 205, 210, 90));
        break;
    case PlotKind::stiffness:
        text = state.stiffness.values_at(plot.area.x_at(mouse.x));
        break;
    case PlotKind::polar:
        text = polar_text(plot.area, mouse, plot.settings);
        break;
    default:
        text = fmt::format("{:.4g}, {:.4g}", plot.area.x_at(mouse.x), plot.area.y_at(mouse.y));
    }
    if (!text.empty()) {
        ui::explain(text);
    }
}

} // namespace

std::string polar_text(const PlotArea &area, ImVec2 place, const PlotSettings &settings) {
    const double x = area.x_at(place.x);
    const double y = area.y_at(place.y);
    return fmt::format("{:.1f}°, {:.4g} {}", kDegreesPerRadian * std::atan2(y, x), std::hypot(x, y),
                       unit_title(without_first(settings)));
}

void use_mouse_on_plot(Plot &plot, PlotPanelState &state, const PlotSource &source,
                       const record::ChannelStore &live) {
    const bool is_hovered = ImGui::IsItemHovered();
    const bool is_active = ImGui::IsItemActive();
    const bool has_axes = plot.settings.kind != PlotKind::polar;
    if (is_hovered && ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left)) {
        plot.settings.x.reset();
        plot.settings.y.reset();
        state.view.go_live();
        return;
    }
    if (is_hovered) {
        zoom_by_wheel(plot, state, source, live);
        read_values(plot, state, source);
    }
    if (ImGui::IsItemActivated()) {
        plot.cursor = cursor_under_mouse(plot, state, source.zero_s);
    }
    if (!is_active) {
        plot.cursor.reset();
    } else if (plot.cursor) {
        state.view.cursor_s[*plot.cursor] =
            plot.area.x_at(ImGui::GetIO().MousePos.x) + source.zero_s;
    } else if (has_axes && ImGui::IsMouseDragging(ImGuiMouseButton_Left)) {
        pan(plot, state, source, live);
    }
    if (has_axes) {
        draw_box(plot, state, source, live);
    }
}

namespace {

std::string lower_case(std::string text) {
    std::ranges::transform(text, text.begin(), [](unsigned char letter) {
        return static_cast<char>(std::tolower(letter));
    });
    return text;
}

/// Whether every word is part of the channel's name, label or explanation.
bool matches(std::size_t channel, const std::string &words) {
    const session::Channel &known = session::channels()[channel];
    const std::string where =
        lower_case(known.name + ' ' + look_of(channel).label + ' ' + explanation_of(known.name));
    std::istringstream stream(lower_case(words));
    std::string word;
    while (stream >> word) {
        if (where.find(word) == std::string::npos) {
            return false;
        }
    }
    return true;
}

/// Makes the previous item a source of a dragged channel.
void offer_channel(const DraggedChannel &dragged) {
    if (!ImGui::BeginDragDropSource()) {
        return;
    }
    ImGui::SetDragDropPayload(kChannelPayload, &dragged, sizeof dragged);
    ImGui::TextUnformatted(look_of(dragged.channel).label.c_str());
    if (dragged.plot != 0) {
        ui::text(kFaintInk, "{}", ImGui::GetIO().KeyCtrl ? "is copied" : "is moved");
    }
    ImGui::EndDragDropSource();
}

void toggle(std::vector<std::size_t> &channels, std::size_t channel) {
    if (std::erase(channels, channel) == 0) {
        channels.push_back(channel);
    }
}

/// A short piece of the channel's curve at the cursor.
void draw_swatch(const Stroke &stroke, PlotKind kind) {
    const float font = ImGui::GetFontSize();
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    ScreenCanvas canvas(*ImGui::GetWindowDrawList(), font / 15.0F);
    draw_sample(canvas, {{corner.x, corner.y + 0.5F * font}, 1.8F * font}, stroke, kind);
    ImGui::Dummy({1.8F * font, font});
}

/// All channels, each with its line, narrowed by a search.
/// @param rows       height of the list
/// @param is_chosen  of a channel
/// @param choose     called with the one that is clicked
template <typename IsChosen, typename Choose>
void draw_channel_list(std::string &searched, float rows, IsChosen &&is_chosen, Choose &&choose) {
    const float font = ImGui::GetFontSize();
    ImGui::SetNextItemWidth(20.0F * font);
    ui::text_field("##search", "search: force, e_W, lateness …", searched);
    ImGui::BeginChild("list", {20.0F * font, rows * font}, true);
    for (std::size_t channel = 0; channel < session::channels().size(); ++channel) {
        if (!matches(channel, searched)) {
            continue;
        }
        const session::Channel &known = session::channels()[channel];
        const bool is_shown = is_chosen(channel);
        const ui::ExplainedRow row(explanation_of(known.name));
        draw_swatch(look_of(channel).stroke, PlotKind::time);
        ImGui::SameLine();
        // Several can be chosen before the menu closes.
        if (ImGui::Selectable(known.name.c_str(), is_shown, ImGuiSelectableFlags_DontClosePopups)) {
            choose(channel);
        }
        ui::enter(known.name, "entry", known.name, is_shown);
        offer_channel({channel});
    }
    ImGui::EndChild();
}

/// Of the level; in a list of its own, as an open menu does not move when it grows.
void draw_trigger_channel(std::size_t &channel, std::string &searched) {
    const ui::DropDown list("##channel", session::channels()[channel].name.c_str());
    if (!list) {
        return;
    }
    draw_channel_list(
        searched, 8.0F, [&](std::size_t other) { return other == channel; },
        [&](std::size_t chosen) {
            channel = chosen;
            ImGui::CloseCurrentPopup();
        });
}

/// One entry of a legend.
struct LegendEntry {
    std::string text;
    std::string values; ///< under the cursors, if there are any
    float width = 0.0F; ///< with its piece of curve, and the gap behind it
};

constexpr float kBesideText = 3.0F; ///< a piece of curve and gaps, in heights of text

std::vector<LegendEntry> legend_entries(const Plot &plot, const PlotPanelState &state,
                                        const PlotSource &source, float width) {
    const bool has_values = state.view.shows_cursors && plot.settings.kind == PlotKind::time;
    const float beside = kBesideText * text_height();
    std::vector<LegendEntry> entries;
    for (const std::size_t channel : plot.settings.channels) {
        LegendEntry entry{legend_text(plot.settings, channel), "", 0.0F};
        if (has_values) {
            entry.values = values_under_cursors(channel, state.view.cursor_s, source.store,
                                                plot.settings.in_si);
        }
        if (text_width(entry.text + entry.values) + beside < width) { // else in the tooltip only
            entry.text += entry.values;
        }
        entry.width = text_width(entry.text) + beside;
        entries.push_back(std::move(entry));
    }
    return entries;
}

/// At the cursor. True if the channel is to be removed.
bool draw_legend_entry(const Plot &plot, std::size_t channel, const LegendEntry &entry,
                       float width) {
    const float font = ImGui::GetFontSize();
    if (pairs_channels(plot.settings.kind) && channel == plot.settings.channels.front()) {
        ImGui::Dummy({1.8F * font, font}); // it has no curve
    } else {
        draw_swatch(look_of(channel).stroke, plot.settings.kind);
    }
    ImGui::SameLine(0.0F, 0.3F * font);
    ImGui::PushID(static_cast<int>(channel));
    const float room = std::max(1.0F, std::min(entry.width, width) - kBesideText * font);
    const bool is_clicked = ImGui::Selectable(entry.text.c_str(), false, 0, {room, 0.0F});
    const session::Channel &known = session::channels()[channel];
    ui::enter(known.name, "legend", entry.text);
    offer_channel({channel, plot.id});
    ui::explain(legend_text(plot.settings, channel) + entry.values +
                "\na click removes it, a drag moves it to another plot, with Ctrl copies it" +
                "\n" + explanation_of(known.name));
    ImGui::PopID();
    return is_clicked;
}

/// All names, in so few lines that they fit into the window.
std::string names_text(const std::vector<LegendEntry> &entries) {
    constexpr std::size_t kMaxLines = 30;
    const std::size_t per_line = (entries.size() + kMaxLines - 1) / kMaxLines;
    std::string text;
    for (std::size_t i = 0; i < entries.size(); ++i) {
        text += (i == 0 ? "" : i % per_line == 0 ? "\n" : ", ") + entries[i].text;
    }
    return text + "\nto be added and removed in the menu";
}

/// The places of legend entries, one behind the other and in as many rows as that needs.
std::vector<ImVec2> places_in_rows(const std::vector<float> &widths, const LegendRoom &room) {
    std::vector<ImVec2> places;
    ImVec2 at{};
    for (const float width : widths) {
        if (at.x > 0.0F && at.x + width > room.size.x) {
            at = {0.0F, at.y + room.row};
        }
        places.push_back(at);
        at.x += width;
    }
    return places;
}

} // namespace

LegendLayout legend_layout(const std::vector<float> &widths, const LegendRoom &room) {
    LegendLayout layout;
    std::vector<float> shown = widths;
    layout.places = places_in_rows(shown, room);
    while (!layout.places.empty() && layout.places.back().y > 0.0F &&
           layout.places.back().y + room.row > room.size.y) {
        // One less, and the number of those that are hidden instead.
        ++layout.hidden;
        shown.resize(widths.size() - layout.hidden);
        shown.push_back(room.more);
        layout.places = places_in_rows(shown, room);
    }
    layout.height = (layout.places.empty() ? 0.0F : layout.places.back().y) + room.row;
    if (layout.hidden > 0) {
        layout.more = layout.places.back();
        layout.places.pop_back();
    }
    return layout;
}

std::string hidden_text(const LegendLayout &layout) {
    return layout.places.empty() ? fmt::format("{} channels", layout.hidden)
                                 : fmt::format("+{} more", layout.hidden);
}

std::string legend_text(const PlotSettings &settings, std::size_t channel) {
    std::string role;
    if (channel == settings.channels.front()) {
        role = settings.kind == PlotKind::xy      ? "to the right: "
               : settings.kind == PlotKind::polar ? "angle: "
                                                  : "";
    }
    return role + look_of(channel).label;
}

std::string values_under_cursors(std::size_t channel, const std::array<double, 2> &cursor_s,
                                 const record::ChannelStore &store, bool in_si) {
    const ShownUnit unit = shown_unit(channel, in_si);
    const auto value_at = [&](double time_s) {
        const std::optional<std::uint64_t> row = store.row_shown_at(time_s);
        return row ? store.value(channel, *row) * unit.per_si
                   : std::numeric_limits<double>::quiet_NaN();
    };
    const auto text_of = [](double value) {
        return std::isnan(value) ? std::string("–") : ui::formatted("{:.4g}", value);
    };
    const double a = value_at(cursor_s[0]);
    const double b = value_at(cursor_s[1]);
    return " A " + text_of(a) + "  B " + text_of(b) + "  Δ " + text_of(b - a) + " " +
           std::string(unit.name);
}

void drop_channel(std::vector<Plot> &plots, Plot &plot, const DraggedChannel &dragged,
                  bool copies) {
    if (dragged.plot == plot.id) {
        return;
    }
    std::vector<std::size_t> &channels = plot.settings.channels;
    if (std::ranges::find(channels, dragged.channel) == channels.end()) {
        channels.push_back(dragged.channel);
    }
    const auto source = std::ranges::find(plots, dragged.plot, &Plot::id);
    if (!copies && source != plots.end()) {
        std::erase(source->settings.channels, dragged.channel);
    }
}

bool draw_plot_menu(Plot &plot) {
    const ui::Scope scope("menu");
    const float font = ImGui::GetFontSize();
    ImGui::SetNextItemWidth(9.0F * font);
    PlotKind kind = plot.settings.kind;
    if (ui::choice("##kind", kind, kPlotKindLabels)) {
        plot.settings.kind = kind;
        plot.settings.x.reset();
        plot.settings.y.reset();
    }
    ImGui::SameLine();
    if (ui::checkbox("SI units", plot.settings.in_si)) {
        plot.settings.x.reset();
        plot.settings.y.reset();
    }
    ImGui::SameLine();
    const bool closes = ui::button("close##close");
    ui::explain("removes this plot");
    std::vector<std::size_t> &shown = plot.settings.channels;
    draw_channel_list(
        plot.searched, 12.0F,
        [&](std::size_t channel) { return std::ranges::find(shown, channel) != shown.end(); },
        [&](std::size_t channel) { toggle(shown, channel); });
    return !closes;
}

float draw_legend(Plot &plot, const PlotPanelState &state, const PlotSource &source, ImVec2 room) {
    const std::vector<LegendEntry> entries = legend_entries(plot, state, source, room.x);
    std::vector<float> widths;
    std::ranges::transform(entries, std::back_inserter(widths), &LegendEntry::width);
    const LegendLayout layout = legend_layout(
        widths, {room, ImGui::GetTextLineHeightWithSpacing(), text_width(kMaxHiddenText)});
    const ImVec2 begin = ImGui::GetCursorScreenPos();
    std::optional<std::size_t> removed;
    for (std::size_t i = 0; i < layout.places.size(); ++i) {
        ImGui::SetCursorScreenPos({begin.x + layout.places[i].x, begin.y + layout.places[i].y});
        const std::size_t channel = plot.settings.channels[i];
        if (draw_legend_entry(plot, channel, entries[i], room.x)) {
            removed = channel;
        }
    }
    if (layout.hidden > 0) {
        ImGui::SetCursorScreenPos({begin.x + layout.more.x, begin.y + layout.more.y});
        ui::text(kFaintInk, "{}", hidden_text(layout));
        ui::explain(names_text(entries));
    }
    if (removed) {
        std::erase(plot.settings.channels, *removed);
    }
    return layout.height;
}

void draw_trigger_menu(PlotPanelState &state, const record::ChannelStore &live) {
    const ui::Scope scope("trigger");
    const float font = ImGui::GetFontSize();
    PlotTriggerSettings &typed = state.typed_trigger;
    ImGui::SetNextItemWidth(9.0F * font);
    ui::choice("event##source", typed.source, kTriggerSourceLabels);
    if (typed.source == TriggerSource::level) {
        ImGui::SetNextItemWidth(12.0F * font);
        draw_trigger_channel(typed.channel, state.trigger.searched);
        ImGui::SameLine();
        ImGui::SetNextItemWidth(8.0F * font);
        ui::choice("##edge", typed.edge, kTriggerEdgeLabels);
        const ShownUnit unit = shown_unit(typed.channel, false);
        double level = typed.level_si * unit.per_si;
        ImGui::SetNextItemWidth(6.0F * font);
        if (ui::number_field("##level", level, "%.4g")) {
            typed.level_si = level / unit.per_si;
        }
        ImGui::SameLine();
        ui::text(kFaintInk, "{}", unit.name);
    }
    ImGui::SetNextItemWidth(9.0F * font);
    double percent = 100.0 * typed.pre_share;
    if (ui::slider_with_number("of the span before the event##pre", percent, 0.0, 100.0,
                               "%.0f %%")) {
        typed.pre_share = percent / 100.0;
    }
    ui::checkbox("again after each event##repeats", typed.repeats);
    if (ui::button("arm")) {
        state.view.go_live();
        state.trigger.arm(typed, state.view.span_s(), live);
        ImGui::CloseCurrentPopup();
    }
}

} // namespace springdrive::app
