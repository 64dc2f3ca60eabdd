// Plots as files.
#include "app/plots/plot_panel.h"

#include "app/host/output.h"
#include "app/host/output_dir.h"
#include "app/plots/channel_look.h"
#include "app/plots/plot_menu.h"
#include "app/widgets/look.h"
#include "base/file_names.h"
#include "base/quoting.h"
#include "engine/session/telemetry_history.h"

#include <algorithm>
#include <array>
#include <filesystem>

namespace springdrive::app {

namespace {

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
