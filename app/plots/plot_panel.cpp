// Plots as files.
#include "app/plots/plot_panel.h"

#include "app/host/folders.h"
#include "app/host/output.h"
#include "app/plots/channels.h"
#include "app/widgets/widgets.h"
#include "base/new_file.h"
#include "base/text.h"
#include "engine/session/telemetry_history.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <initializer_list>
#include <string_view>
#include <utility>

namespace springdrive::app {

namespace {

PlotSettings settings_of(PlotKind kind, std::initializer_list<std::string_view> names) {
    PlotSettings settings;
    settings.kind = kind;
    for (const std::string_view name : names) {
        settings.channels.push_back(session::channel_named(name).value());
    }
    return settings;
}

void add_plot(PlotPanelState &state, PlotSettings settings) {
    Plot plot;
    plot.id = state.next_id++;
    plot.settings = std::move(settings);
    state.plots.push_back(std::move(plot));
}

loops::SpringDrive drive_of(const session::Session &session) {
    loops::SpringDrive drive;
    drive.motor = session.description().motor.front();
    drive.tuning = session.tuning().now();
    drive.period_s = session.servo().period_s();
    drive.delay_periods = session.device().device().delay_periods();
    return drive;
}

std::string span_text(double span_s) {
    return span_s < 1.0    ? fmt::format("{:.3g} ms", 1e3 * span_s)
           : span_s < 60.0 ? fmt::format("{:.3g} s", span_s)
                           : fmt::format("{:.3g} min", span_s / 60.0);
}

void draw_span(PlotPanelState &state) {
    ImGui::SetNextItemWidth(5.2F * ImGui::GetFontSize());
    const ui::DropDown list("##span", span_text(state.view.span_s()).c_str());
    for (const double span_s : {0.01, 0.1, 0.5, 1.0, 2.0, 5.0, 10.0, 30.0, 60.0, 300.0}) {
        if (list && ui::selectable(span_text(span_s).c_str(), span_s == state.view.span_s())) {
            state.view.set_span(span_s);
        }
    }
}

void draw_sets(PlotPanelState &state) {
    ImGui::SetNextItemWidth(4.6F * ImGui::GetFontSize());
    const ui::DropDown list("##sets", "plots");
    if (!list) {
        return;
    }
    for (std::size_t i = 0; i < kPlotSetLabels.size(); ++i) {
        if (ui::selectable(kPlotSetLabels[i], false)) {
            choose_plot_set(state, i);
        }
    }
    ImGui::Separator();
    if (ui::selectable("add a plot", false)) {
        add_plot(state, settings_of(PlotKind::time, {"force_N"}));
    }
}

void draw_exports(PlotPanelState &state, const PlotSource &source, const Rectangle &where,
                  float scale) {
    ImGui::SetNextItemWidth(5.2F * ImGui::GetFontSize());
    const ui::DropDown list("##export", "export");
    if (!list) {
        return;
    }
    if (ui::selectable("CSV, what is shown", false)) {
        export_csv(state, source);
    }
    if (ui::selectable("SVG", false)) {
        export_svg(state, source, where, scale);
    }
    if (ui::selectable("PNG", false)) {
        export_png(state, where);
    }
}

void draw_trigger_button(PlotPanelState &state, const record::ChannelStore &live) {
    const TriggerSource source = state.trigger.settings().source;
    const std::string label = std::string("trigger: ") +
                              kTriggerSourceLabels[static_cast<std::size_t>(source)] + "###trigger";
    const ui::Disabled of_record(state.is_of_record);
    if (ui::button(label.c_str())) {
        if (source != TriggerSource::off) { // otherwise as typed before, to be armed again
            state.typed_trigger = state.trigger.settings();
        }
        ImGui::OpenPopup("trigger");
    }
    ui::explain("stops the plots at the next contact, trip, change of the tuning or passage of a "
                "level");
    if (ImGui::BeginPopup("trigger")) {
        draw_trigger_menu(state, live);
        ImGui::EndPopup();
    }
}

/// A message is shown for some seconds, then the state again.
void forget_old_message(PlotPanelState &state) {
    constexpr double kShown_s = 10.0;
    if (state.message != state.timed_message) {
        state.timed_message = state.message;
        state.message_until_s = ImGui::GetTime() + kShown_s;
    } else if (ImGui::GetTime() > state.message_until_s) {
        state.message.clear();
        state.timed_message.clear();
    }
}

std::string state_text(const PlotPanelState &state, const record::ChannelStore &live) {
    if (!state.message.empty()) {
        return state.message;
    }
    if (const std::string waits = state.trigger.state_text(); !waits.empty()) {
        return waits;
    }
    const double kept_s =
        live.is_empty() ? 0.0 : live.time_s(live.end() - 1) - live.time_s(live.begin());
    if (state.is_of_record) {
        return "a record of " + span_text(kept_s) + (state.view.is_live() ? "" : ", held");
    }
    return (state.view.is_live() ? "live, " : "held, ") + span_text(kept_s) + " kept";
}

void draw_toolbar(PlotPanelState &state, const PlotSource &source, const record::ChannelStore &live,
                  const Rectangle &where, float scale) {
    const bool is_live = state.view.is_live();
    // The same width in both states, so that what follows does not move.
    const char *const label = is_live              ? "pause###hold"
                              : state.is_of_record ? "follow###hold"
                                                   : "live###hold";
    if (ui::button(label, {4.0F * ImGui::GetFontSize(), 0.0F})) {
        toggle_hold(state, live);
    }
    ui::explain(is_live              ? "stops the plots; the servo goes on. Key H"
                : state.is_of_record ? "follows the record again. Key H"
                                     : "follows the present again. Key H");
    ImGui::SameLine();
    draw_span(state);
    ImGui::SameLine();
    draw_trigger_button(state, live);
    ImGui::SameLine();
    if (ui::checkbox("cursors", state.view.shows_cursors) && state.view.shows_cursors) {
        state.view.hold(live); // a live view would leave them behind
        state.view.place_cursors(live);
    }
    ui::explain("two times to be dragged in the plots, with the values there and their "
                "differences");
    ImGui::SameLine();
    ui::checkbox("A/B", state.shows_trace);
    ui::explain("shows faintly what was shown when the other slot of the tuning was left: key B");
    ImGui::SameLine();
    draw_sets(state);
    ImGui::SameLine();
    draw_exports(state, source, where, scale);
    ImGui::SameLine();
    if (ui::button("\u2195##large")) {
        state.is_large = !state.is_large;
    }
    ui::explain(state.is_large
                    ? "makes room for the scene again"
                    : "shows the plots over the scene; their upper edge can be dragged, too");
    const std::string text = state_text(state, live);
    ImGui::SameLine();
    const float left = ImGui::GetCursorScreenPos().x;
    const float right = where.end().x;
    forget_old_message(state);
    if (left + text_width(text) < right) {
        ui::text(kFaintInk, "{}", text);
    } else if (left + text_width("…") < right) {
        ui::text(state.message.empty() ? kFaintInk : kWarning, "…");
        ui::explain(text);
    } else {
        ImGui::NewLine();
    }
}

/// Moves the panel's upper edge.
void draw_handle(PlotPanelState &state, const Rectangle &place, float scale) {
    const float thickness = 5.0F * scale;
    ImGui::SetCursorScreenPos(place.corner);
    ImGui::InvisibleButton("##handle", {place.size.x, thickness});
    ui::enter("handle", "handle", "");
    if (ImGui::IsItemHovered() || ImGui::IsItemActive()) {
        ImGui::SetMouseCursor(ImGuiMouseCursor_ResizeNS);
    }
    if (ImGui::IsItemActive() && !state.is_large) {
        state.height -= ImGui::GetIO().MouseDelta.y / scale;
        state.height = std::clamp(state.height, 150.0F, 1500.0F);
    }
}

void draw_cursor_lines(Canvas &canvas, const PlotPanelState &state, const PlotArea &area,
                       double zero_s) {
    for (std::size_t i = 0; i < 2; ++i) {
        const float x = area.place_x(state.view.cursor_s[i] - zero_s);
        if (x < area.where.corner.x || x > area.where.corner.x + area.where.size.x) {
            continue;
        }
        canvas.line({x, area.where.corner.y}, {x, area.where.end().y},
                    {kInk, 1.2F, i == 0 ? Dash::solid : Dash::dashed});
        canvas.text({x + 0.2F * text_height(), area.where.corner.y}, kInk, i == 0 ? "A" : "B");
    }
    const double apart_s = state.view.cursor_s[1] - state.view.cursor_s[0];
    const std::string text = apart_s == 0.0 ? "B − A: 0 s"
                                            : fmt::format("B − A: {:.4g} ms, {:.4g} Hz",
                                                          1e3 * apart_s, 1.0 / std::abs(apart_s));
    canvas.text({area.where.end().x - text_width(text) - 0.3F * text_height(),
                 area.where.end().y - 1.1F * text_height()},
                kInk, text);
}

/// When a slot is left, what was shown with its tuning becomes its trace.
void keep_trace(const session::TuningSlots &slots, PlotPanelState &state,
                const record::ChannelStore &live) {
    if (slots.active() == state.slot) {
        return;
    }
    state.traces[static_cast<std::size_t>(state.slot)] =
        PlotTrace{state.view.store(live), state.view.window(live),
                  "slot " + std::string(session::name_of(state.slot))};
    state.slot = slots.active();
}

/// Another subject is shown as it goes on.
void turn_to(const PlotSubject &subject, PlotPanelState &state) {
    state.view.follow(subject.position_s);
    state.is_of_record = subject.position_s.has_value();
    if (std::exchange(state.subject, subject.number) != subject.number) {
        state.view.go_live();
        state.trigger = {};
        for (Plot &plot : state.plots) {
            plot.cache = {}; // rows of the same numbers are others now
        }
    }
}

/// May be null.
const PlotTrace *trace_behind(const PlotSubject &subject, const session::TuningSlots &slots,
                              const PlotPanelState &state) {
    if (subject.trace != nullptr || state.is_of_record || !state.shows_trace) {
        return subject.trace;
    }
    const std::optional<PlotTrace> &other =
        state.traces[static_cast<std::size_t>(slots.inactive())];
    return other ? &*other : nullptr;
}

/// Enters the plot into the window's report.
void report_plot(const Plot &plot, const PlotPanelState &state) {
    std::string names;
    for (const std::size_t channel : plot.settings.channels) {
        names += (names.empty() ? "" : ", ") + session::channels()[channel].name;
    }
    ui::enter("area", "plot", kPlotKindLabels[static_cast<std::size_t>(plot.settings.kind)], names,
              {{"x_from", plot.area.x.from},
               {"x_to", plot.area.x.to},
               {"y_from", plot.area.y.from},
               {"y_to", plot.area.y.to},
               {"area_x", plot.area.where.corner.x},
               {"area_y", plot.area.where.corner.y},
               {"area_width", plot.area.where.size.x},
               {"area_height", plot.area.where.size.y},
               {"is_live", state.view.is_live() ? 1.0 : 0.0},
               {"cursor_a_s", state.view.cursor_s[0]},
               {"cursor_b_s", state.view.cursor_s[1]}});
}

/// Accepts a channel that is dragged here from a list or another plot.
void accept_channel(Plot &plot, PlotPanelState &state) {
    if (!ImGui::BeginDragDropTarget()) {
        return;
    }
    if (const ImGuiPayload *payload = ImGui::AcceptDragDropPayload(kChannelPayload)) {
        DraggedChannel dragged;
        std::memcpy(&dragged, payload->Data, sizeof dragged); // which may not be aligned
        drop_channel(state.plots, plot, dragged, ImGui::GetIO().KeyCtrl);
    }
    ImGui::EndDragDropTarget();
}

/// False if the plot is to be closed.
bool draw_one(Plot &plot, PlotPanelState &state, const PlotSource &source,
              const record::ChannelStore &live, const Rectangle &where, float scale) {
    const ui::Scope scope(fmt::format("plot {}", plot.id));
    // Whatever the plot has no room for must not cover its neighbours.
    ImGui::PushClipRect(where.corner, where.end(), true);
    float head = ImGui::GetFrameHeight();
    ImGui::SetCursorScreenPos(where.corner);
    if (ui::small_button("≡##menu")) {
        ImGui::OpenPopup("menu");
    }
    ui::explain("kind of plot, channels and units");
    bool stays = true;
    ImGui::SetNextWindowSizeConstraints({0.0F, 0.0F}, {1e4F, ImGui::GetIO().DisplaySize.y});
    if (ImGui::BeginPopup("menu")) {
        stays = draw_plot_menu(plot);
        ImGui::EndPopup();
    }
    ImGui::SameLine();
    if (plot.settings.kind == PlotKind::stiffness) {
        if (state.stiffness.is_sweeping()) {
            ui::text(kFaintInk, "measuring, {:.0f} %", 100.0 * state.stiffness.share());
        } else if (ui::small_button("measure by a sweep##sweep")) {
            state.stiffness.start_sweep();
        }
        ui::explain("sine by sine on a simulated motor held at its set-point, with the active "
                    "tuning;\nthe device in the scene is not disturbed");
    } else {
        const float used = ImGui::GetCursorScreenPos().x - where.corner.x;
        const ImVec2 room{where.size.x - used, kLegendShare * where.size.y};
        head = std::max(head, draw_legend(plot, state, source, room));
    }
    head = std::min(head, where.size.y - 1.0F);
    const Rectangle contents{{where.corner.x, where.corner.y + head},
                             {where.size.x, where.size.y - head}};
    ScreenCanvas canvas(*ImGui::GetWindowDrawList(), scale);
    plot.area = draw_contents(canvas, contents, plot, state, source);
    ImGui::SetCursorScreenPos(contents.corner);
    ImGui::InvisibleButton("##area", contents.size);
    report_plot(plot, state);
    accept_channel(plot, state);
    use_mouse_on_plot(plot, state, source, live);
    ImGui::PopClipRect();
    return stays;
}

/// "plots-20240531-123456.csv", or with a number if that was written in the same second.
std::filesystem::path name_of_new_file(const char *ending) {
    return unused_name(in_output_dir(dated_name("plots") + ending));
}

/// Each channel of any plot, once.
std::vector<std::size_t> all_channels(const PlotPanelState &state) {
    std::vector<std::size_t> all;
    for (const Plot &plot : state.plots) {
        for (const std::size_t channel : plot.settings.channels) {
            if (std::ranges::find(all, channel) == all.end()) {
                all.push_back(channel);
            }
        }
    }
    return all;
}

/// The names of the channels, as those above the plot in the window. @return their height
float draw_names(Canvas &canvas, const Rectangle &where, const PlotSettings &settings) {
    const float height = text_height();
    std::vector<float> widths;
    for (const std::size_t channel : settings.channels) {
        widths.push_back(text_width(legend_text(settings, channel)) + 2.6F * height);
    }
    const LegendLayout layout = legend_layout(
        widths,
        {{where.size.x, kLegendShare * where.size.y}, 1.3F * height, text_width(kMaxHiddenText)});
    for (std::size_t i = 0; i < layout.places.size(); ++i) {
        const ImVec2 at{where.corner.x + layout.places[i].x, where.corner.y + layout.places[i].y};
        const std::size_t channel = settings.channels[i];
        if (i > 0 || !pairs_channels(settings.kind)) {
            draw_sample(canvas, {{at.x, at.y + 0.5F * height}, 1.4F * height},
                        look_of(channel).stroke, settings.kind);
        }
        canvas.text({at.x + 1.7F * height, at.y}, kInk, legend_text(settings, channel));
    }
    if (layout.hidden > 0) {
        canvas.text({where.corner.x + layout.more.x, where.corner.y + layout.more.y}, kFaintInk,
                    hidden_text(layout));
    }
    return layout.height;
}

} // namespace

void toggle_hold(PlotPanelState &state, const record::ChannelStore &live) {
    if (state.view.is_live()) {
        state.view.hold(live);
    } else {
        state.view.go_live();
    }
}

void move_in_time(PlotPanelState &state, const record::ChannelStore &live, double span,
                  double shift) {
    const signals::TimeWindow before = state.view.window(live);
    const double middle_s = 0.5 * (before.from_s + before.to_s);
    const double length_s = span * (before.to_s - before.from_s);
    const double from_s = middle_s + (shift - 0.5) * length_s;
    state.view.show(live, {from_s, from_s + length_s});
}

PlotPanelState::PlotPanelState() { choose_plot_set(*this, 0); }

void choose_plot_set(PlotPanelState &state, std::size_t index) {
    constexpr double kSpanOfFigures_s = 60.0; // to touch all round a sphere
    state.plots.clear();
    const auto add = [&](PlotKind kind, std::initializer_list<std::string_view> names) {
        add_plot(state, settings_of(kind, names));
    };
    switch (index) {
    case 1:
        state.view.set_span(kSpanOfFigures_s);
        add(PlotKind::xy, {"force_outward_N", "force_up_N"});
        add(PlotKind::polar, {"normal_direction_rad", "force_N"});
        break;
    case 2:
        state.view.set_span(kSpanOfFigures_s);
        add(PlotKind::polar, {"normal_direction_rad", "inverse_error_rad", "transpose_error_rad",
                              "inverse_measured_rad", "transpose_measured_rad"});
        add(PlotKind::xy, {"normal_direction_rad", "inverse_error_rad", "transpose_error_rad",
                           "inverse_measured_rad", "transpose_measured_rad"});
        break;
    case 3:
        add(PlotKind::time, {"e_W1_V", "e_W2_V", "e_W3_V"});
        add(PlotKind::time, {"current1_A", "current2_A", "current3_A"});
        add(PlotKind::time, {"winding_greatest1_C", "winding_greatest2_C", "winding_greatest3_C"});
        break;
    case 4:
        add(PlotKind::histogram, {"period_s"});
        add(PlotKind::histogram, {"compute_s"});
        add(PlotKind::time, {"lateness_s"});
        break;
    case 5:
        add(PlotKind::stiffness, {});
        add(PlotKind::time, {"force_N"});
        break;
    case 6:
        add(PlotKind::spectrum, {"force_N"});
        add(PlotKind::time, {"force_N"});
        break;
    default:
        add(PlotKind::time, {"rendered_error_rad", "transpose_measured_rad", "transpose_error_rad",
                             "inverse_measured_rad", "inverse_error_rad"});
        add(PlotKind::time, {"force_N"});
        break;
    }
}

std::vector<Rectangle> plot_places(const Rectangle &where, const std::vector<Plot> &plots) {
    const std::size_t count = plots.size();
    // As many columns as make the plots about twice as wide as high.
    std::size_t columns = 1;
    const auto rows_for = [&](std::size_t some) { return (count + some - 1) / some; };
    while (columns < count && where.size.x / static_cast<float>(columns) >
                                  3.0F * where.size.y / static_cast<float>(rows_for(columns))) {
        ++columns;
    }
    const float height =
        where.size.y / static_cast<float>(std::max<std::size_t>(1, rows_for(columns)));
    const float gap = 0.6F * text_height();
    const auto weight_of = [](const Plot &plot) {
        return plot.settings.channels.size() > 3 ? 1.6F : 1.0F;
    };
    std::vector<Rectangle> places;
    for (std::size_t first = 0; first < count; first += columns) {
        const std::size_t last = std::min(count, first + columns);
        float weights = 0.0F;
        for (std::size_t i = first; i < last; ++i) {
            weights += weight_of(plots[i]);
        }
        float left = where.corner.x;
        const std::size_t row = first / columns;
        for (std::size_t i = first; i < last; ++i) {
            const float width = where.size.x * weight_of(plots[i]) / weights;
            places.push_back({{left, where.corner.y + height * static_cast<float>(row)},
                              {std::max(1.0F, width - gap), std::max(1.0F, height - 0.5F * gap)}});
            left += width;
        }
    }
    return places;
}

PlotArea draw_contents(Canvas &canvas, const Rectangle &where, Plot &plot, PlotPanelState &state,
                       const PlotSource &source) {
    if (plot.settings.kind == PlotKind::stiffness) {
        return state.stiffness.draw(canvas, where, plot.settings);
    }
    const PlotArea area = draw_plot(canvas, where, plot.settings, source, plot.cache);
    if (plot.settings.kind == PlotKind::time && state.view.shows_cursors) {
        draw_cursor_lines(canvas, state, area, source.zero_s);
    }
    return area;
}

void draw_plot_panel(session::Session &session, const PlotSubject &subject,
                     const session::TuningSlots &slots, PlotPanelState &state,
                     const Rectangle &place, float scale) {
    const record::ChannelStore &live = subject.store;
    turn_to(subject, state);
    if (!state.is_of_record) {
        state.trigger.advance(live, state.view);
        keep_trace(slots, state, live);
    }
    state.slot = slots.active();
    state.stiffness.update(drive_of(session));
    const signals::TimeWindow window = state.view.window(live);
    // A press of a button may end the hold while this frame is being drawn.
    const std::shared_ptr<const record::ChannelStore> held = state.view.held();
    const PlotSource source{held ? *held : live, subject.servo_hz, window,
                            // The time of a record is its own.
                            state.view.is_live() && !state.is_of_record ? window.to_s : 0.0,
                            trace_behind(subject, slots, state),
                            // The answer belongs to the record's own time.
                            state.is_of_record && subject.trace != nullptr
                                ? subject.trace->window.to_s
                                : state.view.reference_end_s(live)};
    const ui::Panel panel("Plots", place,
                          ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoScrollbar |
                              ImGuiWindowFlags_NoScrollWithMouse);
    const ImVec2 begin = ImGui::GetCursorScreenPos();
    draw_handle(state, place, scale);
    ImGui::SetCursorScreenPos(begin);
    const float top = begin.y + ImGui::GetFrameHeightWithSpacing();
    const float margin = ImGui::GetStyle().WindowPadding.x;
    const Rectangle where{
        {begin.x, top}, {place.size.x - 2.0F * margin, place.end().y - top - 0.3F * text_height()}};
    draw_toolbar(state, source, live, where, scale);
    const std::vector<Rectangle> places = plot_places(where, state.plots);
    std::size_t drawn = 0;
    std::erase_if(state.plots, [&](Plot &plot) {
        plot.cache.begin(ImGui::GetTime());
        return !draw_one(plot, state, source, live, places[drawn++], scale);
    });
}

void export_csv(PlotPanelState &state, const PlotSource &source) {
    state.message = save_as(name_of_new_file(".csv"), [&](std::ostream &out) {
        const std::vector<std::size_t> channels = all_channels(state);
        out << "time_s";
        for (const std::size_t channel : channels) {
            out << ',' << session::channels()[channel].name;
        }
        out << '\n';
        const record::ChannelStore &store = source.store;
        for (std::uint64_t row = store.row_at(source.window.from_s);
             row < store.end() && store.time_s(row) <= source.window.to_s; ++row) {
            out << csv_cell(store.time_s(row));
            for (const std::size_t channel : channels) {
                out << ',' << csv_cell(store.value(channel, row));
            }
            out << '\n';
        }
    });
}

void export_svg(PlotPanelState &state, const PlotSource &source, const Rectangle &where,
                float scale) {
    SvgCanvas canvas(where, scale);
    canvas.fill(where, ImVec4(0.115F, 0.127F, 0.15F, 1.0F));
    const std::vector<Rectangle> places = plot_places(where, state.plots);
    for (std::size_t i = 0; i < places.size(); ++i) {
        const Rectangle &place = places[i];
        canvas.clip(place);
        const float head = draw_names(canvas, place, state.plots[i].settings);
        const Rectangle contents{{place.corner.x, place.corner.y + head},
                                 {place.size.x, place.size.y - head}};
        static_cast<void>(draw_contents(canvas, contents, state.plots[i], state, source));
        canvas.unclip();
    }
    state.message =
        save_as(name_of_new_file(".svg"), [&](std::ostream &out) { out << canvas.svg(); });
}

void export_png(PlotPanelState &state, const Rectangle &where) {
    state.picture = {name_of_new_file(".png"), where}; // when the frame is complete
}

} // namespace springdrive::app
