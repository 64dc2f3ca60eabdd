// The menus of plots: kind, channels, units, trigger; and the legend, from which channels are
// dragged.
#include "app/plots/channel_look.h"
#include "app/plots/plot_panel.h"
#include "app/widgets/widgets.h"
#include "engine/session/telemetry_history.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <sstream>

namespace springdrive::app {

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
        lower_case(known.name + ' ' + look_of(channel).label + ' ' + known.about);
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
void offer_channel(std::size_t channel) {
    if (ImGui::BeginDragDropSource()) {
        ImGui::SetDragDropPayload(kChannelPayload, &channel, sizeof channel);
        ImGui::TextUnformatted(look_of(channel).label.c_str());
        ImGui::EndDragDropSource();
    }
}

void toggle(std::vector<std::size_t> &channels, std::size_t channel) {
    if (std::erase(channels, channel) == 0) {
        channels.push_back(channel);
    }
}

/// A short piece of the channel's line at the cursor.
void draw_swatch(const Stroke &stroke) {
    const float font = ImGui::GetFontSize();
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    ScreenCanvas canvas(*ImGui::GetWindowDrawList(), font / 15.0F);
    const float y = corner.y + 0.5F * font;
    canvas.line({corner.x, y}, {corner.x + 1.8F * font, y}, {stroke.colour, 2.0F, stroke.dash});
    ImGui::Dummy({1.8F * font, font});
}

void draw_channel_list(Plot &plot) {
    const float font = ImGui::GetFontSize();
    ImGui::SetNextItemWidth(20.0F * font);
    ui::text_field("##search", "search: force, e_W, lateness …", plot.searched);
    ImGui::BeginChild("list", {20.0F * font, 12.0F * font}, true);
    for (std::size_t channel = 0; channel < session::channels().size(); ++channel) {
        if (!matches(channel, plot.searched)) {
            continue;
        }
        const session::Channel &known = session::channels()[channel];
        const bool is_shown =
            std::ranges::find(plot.settings.channels, channel) != plot.settings.channels.end();
        draw_swatch(look_of(channel).stroke);
        ImGui::SameLine();
        // Several can be chosen before the menu closes.
        if (ImGui::Selectable(known.name.c_str(), is_shown, ImGuiSelectableFlags_DontClosePopups)) {
            toggle(plot.settings.channels, channel);
        }
        ui::enter(known.name, "entry", known.name, is_shown);
        offer_channel(channel);
        if (!known.about.empty()) {
            ui::explain(known.about);
        }
    }
    ImGui::EndChild();
}

/// The values of a channel under the cursors, and their difference.
std::string values_under_cursors(std::size_t channel, const PlotPanelState &state,
                                 const PlotSource &source, bool in_si) {
    const ShownUnit unit = shown_unit(channel, in_si);
    std::array<double, 2> values{};
    for (std::size_t i = 0; i < 2; ++i) {
        const std::uint64_t row = source.store.row_at(state.view.cursor_s[i]);
        values[i] = row == source.store.end() ? std::numeric_limits<double>::quiet_NaN()
                                              : source.store.value(channel, row) * unit.per_si;
    }
    const auto text_of = [](double value) {
        return std::isnan(value) ? std::string("–") : ui::formatted("{:.4g}", value);
    };
    return " A " + text_of(values[0]) + "  B " + text_of(values[1]) + "  Δ " +
           text_of(values[1] - values[0]) + " " + std::string(unit.name);
}

/// What the first channel is for, where it is for something else than the others.
std::string role_of(const PlotSettings &settings, std::size_t channel) {
    if (channel != settings.channels.front()) {
        return "";
    }
    return settings.kind == PlotKind::xy      ? "to the right: "
           : settings.kind == PlotKind::polar ? "angle: "
                                              : "";
}

} // namespace

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
    draw_channel_list(plot);
    return !closes;
}

float draw_legend(Plot &plot, const PlotPanelState &state, const PlotSource &source, float width) {
    const bool has_values = state.view.shows_cursors && plot.settings.kind == PlotKind::time;
    std::optional<std::size_t> removed;
    const ImVec2 begin = ImGui::GetCursorScreenPos();
    const float row = ImGui::GetTextLineHeightWithSpacing();
    ImVec2 at = begin;
    for (const std::size_t channel : plot.settings.channels) {
        const ChannelLook &look = look_of(channel);
        std::string text = role_of(plot.settings, channel) + look.label;
        std::string values;
        if (has_values) {
            values = values_under_cursors(channel, state, source, plot.settings.in_si);
        }
        const float swatch = 3.0F * ImGui::GetFontSize();
        if (text_width(text + values) + swatch < width) { // otherwise in the tooltip only
            text += values;
        }
        const float needed = text_width(text) + swatch;
        if (at.x > begin.x && at.x + needed > begin.x + width) {
            at = {begin.x, at.y + row};
        }
        ImGui::SetCursorScreenPos(at);
        at.x += needed;
        draw_swatch(look.stroke);
        ImGui::SameLine(0.0F, 0.3F * ImGui::GetFontSize());
        ImGui::PushID(static_cast<int>(channel));
        if (ImGui::Selectable(text.c_str(), false, 0, {text_width(text), 0.0F})) {
            removed = channel;
        }
        ui::enter(session::channels()[channel].name, "legend", text);
        offer_channel(channel);
        const session::Channel &known = session::channels()[channel];
        ui::explain(known.name + values + "\na click removes it, a drag takes it to another plot" +
                    (known.about.empty() ? "" : "\n" + known.about));
        ImGui::PopID();
    }
    if (removed) {
        std::erase(plot.settings.channels, *removed);
    }
    return at.y + row - begin.y;
}

void draw_trigger_menu(PlotPanelState &state, const record::ChannelStore &live) {
    const ui::Scope scope("trigger");
    const float font = ImGui::GetFontSize();
    PlotTriggerSettings &typed = state.typed_trigger;
    ImGui::SetNextItemWidth(9.0F * font);
    ui::choice("event##source", typed.source, kTriggerSourceLabels);
    if (typed.source == TriggerSource::level) {
        const session::Channel &channel = session::channels()[typed.channel];
        ImGui::SetNextItemWidth(12.0F * font);
        if (const ui::DropDown list("##channel", channel.name.c_str()); list) {
            for (const Plot &plot : state.plots) {
                for (const std::size_t shown : plot.settings.channels) {
                    if (ui::selectable(session::channels()[shown].name.c_str(),
                                       shown == typed.channel)) {
                        typed.channel = shown;
                    }
                }
            }
        }
        ImGui::SameLine();
        ImGui::SetNextItemWidth(8.0F * font);
        ui::choice("##edge", typed.edge, kTriggerEdgeLabels);
        const ShownUnit unit = shown_unit(typed.channel, false);
        double level = typed.level_si * unit.per_si;
        ImGui::SetNextItemWidth(6.0F * font);
        ui::number_field("##level", level, "%.4g");
        typed.level_si = level / unit.per_si;
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
