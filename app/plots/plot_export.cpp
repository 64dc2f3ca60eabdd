// Plots as files.
#include "app/plots/plot_panel.h"

#include "app/commands/output_files.h"
#include "app/plots/channel_look.h"
#include "app/widgets/look.h"
#include "base/file_names.h"
#include "base/print.h"
#include "engine/session/telemetry_history.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <functional>

namespace springdrive::app {

namespace {

/// "plots-20240531-123456.csv", or with a number if that was written in the same second.
std::string name_of_new_file(const char *ending) {
    return unused_name(dated_name("plots"), ending,
                       [](const std::string &name) { return std::filesystem::exists(name); });
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
    const float height = text_height();
    for (std::size_t i = 0; i < places.size(); ++i) {
        ImVec2 at = places[i].corner;
        const float right = places[i].corner.x + places[i].size.x;
        for (const std::size_t channel : state.plots[i].settings.channels) {
            const ChannelLook &look = look_of(channel);
            const float width = text_width(look.label) + 2.6F * height;
            if (at.x > places[i].corner.x && at.x + width > right) {
                at = {places[i].corner.x, at.y + 1.3F * height};
            }
            canvas.line({at.x, at.y + 0.5F * height}, {at.x + 1.4F * height, at.y + 0.5F * height},
                        {look.stroke.colour, 2.0F, look.stroke.dash});
            canvas.text({at.x + 1.7F * height, at.y}, kInk, look.label);
            at.x += width;
        }
        const float top = at.y + 1.4F * height;
        const Rectangle contents{{places[i].corner.x, top},
                                 {places[i].size.x, places[i].corner.y + places[i].size.y - top}};
        static_cast<void>(draw_contents(canvas, contents, state.plots[i], state, source));
    }
    state.message =
        save_as(name_of_new_file(".svg"), [&](std::ostream &out) { out << canvas.svg(); });
}

void export_png(PlotPanelState &state, const Rectangle &where) {
    state.picture = {name_of_new_file(".png"), where}; // when the frame is complete
}

} // namespace springdrive::app
