#include "app/plots/plot_view.h"

#include "engine/control/tuning.h"
#include "engine/session/telemetry_history.h"

#include <algorithm>

namespace springdrive::app {

namespace {

using signals::TriggerCondition;
using signals::TriggerEdge;

/// Between the values of a yes or no.
constexpr double kHalf = 0.5;

std::vector<std::size_t> channels_of_tuning() {
    std::vector<std::string_view> names{"map", "alpha_mode"};
    for (const control::Parameter &parameter : control::kParameters) {
        names.push_back(parameter.name);
    }
    std::vector<std::size_t> channels;
    for (const std::string_view name : names) {
        if (const std::optional<std::size_t> channel = session::channel_named(name)) {
            channels.push_back(*channel);
        }
    }
    return channels;
}

} // namespace

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

void PlotView::show(const record::ChannelStore &live, const signals::TimeWindow &requested) {
    hold(live);
    const signals::TimeWindow before = window(live);
    const double length_s = requested.to_s - requested.from_s;
    const double span_before_s = span_s_;
    zoom_to_span(length_s);
    end_s_ = requested.to_s;
    if (span_s_ != length_s && span_s_ == span_before_s) {
        end_s_ = before.to_s; // it was at the end already: stays to the last bit
    } else if (span_s_ != length_s) {
        // At the end of zooming: the time at which both windows agree stays where it is.
        const double old_s = before.to_s - before.from_s;
        const double share =
            old_s == length_s ? 1.0 : (requested.from_s - before.from_s) / (old_s - length_s);
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

void PlotTrigger::arm(const PlotTriggerSettings &settings, double span_s,
                      const record::ChannelStore &live) {
    settings_ = settings;
    watches_.clear();
    next_row_ = live.end();
    const auto watch = [this](std::size_t channel, const TriggerCondition &condition) {
        watches_.push_back({channel, signals::EdgeDetector(condition)});
    };
    switch (settings.source) {
    case TriggerSource::off:
        break;
    case TriggerSource::contact:
        watch(session::channel_named("touching").value(), {TriggerEdge::rising, kHalf});
        break;
    case TriggerSource::trip:
        watch(session::channel_named("trip_cause").value(), {TriggerEdge::rising, kHalf});
        break;
    case TriggerSource::gain_change:
        for (const std::size_t channel : channels_of_tuning()) {
            watch(channel, {TriggerEdge::change, 0.0});
        }
        break;
    case TriggerSource::level:
        watch(settings.channel, {settings.edge, settings.level_si});
        break;
    }
    if (!live.is_empty()) { // an event is a change from now on
        static_cast<void>(fires(live, live.end() - 1));
    }
    const double pre_s = settings.pre_share * span_s;
    // A gain glides for some fifty milliseconds: one event.
    trigger_ = signals::Trigger(
        {settings.repeats ? signals::TriggerMode::repeating : signals::TriggerMode::single, pre_s,
         span_s - pre_s});
}

bool PlotTrigger::fires(const record::ChannelStore &live, std::uint64_t row) {
    bool fires = false;
    for (Watch &watch : watches_) {
        fires |= watch.detector.take(live.value(watch.channel, row));
    }
    return fires;
}

void PlotTrigger::advance(const record::ChannelStore &live, PlotView &view) {
    if (settings_.source == TriggerSource::off) {
        return;
    }
    for (std::uint64_t row = std::max(next_row_, live.begin()); row < live.end(); ++row) {
        const bool has_event = fires(live, row); // also while it is ignored
        trigger_.take(live.time_s(row), has_event && !view.is_held_by_hand());
        const std::optional<signals::TimeWindow> window = trigger_.window();
        if (!window) {
            continue;
        }
        if (view.is_held_by_hand()) {
            trigger_.arm(); // the user is looking at something else
            continue;
        }
        view.show_event(live, *window);
        trigger_.proceed();
        if (!settings_.repeats) {
            settings_.source = TriggerSource::off;
            return;
        }
    }
    next_row_ = live.end();
}

const char *PlotTrigger::state_text() const {
    if (settings_.source == TriggerSource::off) {
        return "";
    }
    switch (trigger_.state()) {
    case signals::TriggerState::waiting:
        return "waiting for the event";
    case signals::TriggerState::collecting:
        return "collecting";
    case signals::TriggerState::complete:
        break;
    }
    return "";
}

} // namespace springdrive::app
