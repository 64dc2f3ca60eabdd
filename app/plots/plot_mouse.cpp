// The mouse on a plot: the wheel and drags zoom and pan, the pointer reads values.
#include "app/plots/plot_panel.h"

#include "app/plots/channel_look.h"
#include "app/widgets/widgets.h"
#include "base/degrees.h"
#include "engine/session/telemetry_history.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

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

} // namespace springdrive::app
