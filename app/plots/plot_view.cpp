#include "app/plots/plot_view.h"

#include <algorithm>

namespace springdrive::app {

signals::TimeWindow PlotView::window(const record::ChannelStore &live) const {
    const double newest_s = live.is_empty() ? 0.0 : live.time_s(live.end() - 1);
    const double end_s = is_live() ? followed_s_.value_or(newest_s) : end_s_;
    return {end_s - span_s_, end_s};
}

void PlotView::hold(const record::ChannelStore &live) {
    if (is_live()) {
        end_s_ = reference_end_s_ = window(live).to_s;
        held_ = std::make_shared<const record::ChannelStore>(live);
    }
    held_by_hand_ = true;
}

void PlotView::show_event(const record::ChannelStore &live, const signals::TimeWindow &window) {
    held_ = std::make_shared<const record::ChannelStore>(live); // with the event
    zoom_to_span(window.to_s - window.from_s);
    end_s_ = reference_end_s_ = window.to_s;
    held_by_hand_ = false;
}

void PlotView::show(const record::ChannelStore &live, const signals::TimeWindow &wanted) {
    hold(live);
    const signals::TimeWindow before = window(live);
    const double length_s = wanted.to_s - wanted.from_s;
    const double span_before_s = span_s_;
    zoom_to_span(length_s);
    end_s_ = wanted.to_s;
    if (span_s_ != length_s && span_s_ == span_before_s) {
        end_s_ = before.to_s; // it was at the end already: stays to the last bit
    } else if (span_s_ != length_s) {
        // At the end of zooming: the time at which both windows agree stays where it is.
        const double old_s = before.to_s - before.from_s;
        const double share =
            old_s == length_s ? 1.0 : (wanted.from_s - before.from_s) / (old_s - length_s);
        const double fixed_s = before.from_s + share * old_s;
        end_s_ = fixed_s + (1.0 - share) * span_s_;
    }
}

void PlotView::set_span(double span_s) {
    zoom_to_span(span_s);
    chosen_span_s_ = span_s_;
}

void PlotView::zoom_to_span(double span_s) { span_s_ = std::clamp(span_s, kMinSpan_s, kMaxSpan_s); }

void PlotView::place_cursors(const record::ChannelStore &live) {
    const signals::TimeWindow now = window(live);
    const double third_s = (now.to_s - now.from_s) / 3.0;
    cursor_s = {now.from_s + third_s, now.to_s - third_s};
}

} // namespace springdrive::app
