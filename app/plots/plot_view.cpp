#include "app/plots/plot_view.h"

#include <algorithm>

namespace springdrive::app {

signals::TimeWindow PlotView::window(const record::ChannelStore &live) const {
    const double newest_s = live.is_empty() ? 0.0 : live.time_s(live.end() - 1);
    const double end_s = is_live() ? newest_s : end_s_;
    return {end_s - span_s_, end_s};
}

void PlotView::hold(const record::ChannelStore &live) {
    if (is_live()) {
        end_s_ = reference_end_s_ = window(live).to_s;
        held_ = live;
    }
}

void PlotView::show_event(const record::ChannelStore &live, const signals::TimeWindow &window) {
    go_live(); // the snapshot must hold the event
    show(live, window);
    reference_end_s_ = end_s_;
}

void PlotView::show(const record::ChannelStore &live, const signals::TimeWindow &window) {
    hold(live);
    set_span(window.to_s - window.from_s);
    end_s_ = window.to_s;
}

void PlotView::set_span(double span_s) {
    span_s_ = std::clamp(span_s, kLeastSpan_s, kGreatestSpan_s);
}

void PlotView::place_cursors(const record::ChannelStore &live) {
    const signals::TimeWindow now = window(live);
    const double third_s = (now.to_s - now.from_s) / 3.0;
    cursor_s = {now.from_s + third_s, now.to_s - third_s};
}

} // namespace springdrive::app
