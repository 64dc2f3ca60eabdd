#include "app/plots/plot_trigger.h"

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
        watch(session::channel_named("touching").value(), {TriggerEdge::rising, kHalf, 0.0});
        break;
    case TriggerSource::trip:
        watch(session::channel_named("trip_cause").value(), {TriggerEdge::rising, kHalf, 0.0});
        break;
    case TriggerSource::gain_change:
        for (const std::size_t channel : channels_of_tuning()) {
            watch(channel, {TriggerEdge::change, 0.0, 0.0});
        }
        break;
    case TriggerSource::level:
        watch(settings.channel, {settings.edge, settings.level_si, 0.0});
        break;
    }
    if (!live.is_empty()) { // an event is a change from now on
        static_cast<void>(fires(live, live.end() - 1));
    }
    const double pre_s = settings.pre_share * span_s;
    // A gain glides for some fifty milliseconds: one event.
    trigger_ = signals::Trigger(
        {settings.repeats ? signals::TriggerMode::repeating : signals::TriggerMode::single, pre_s,
         span_s - pre_s, 0.0});
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
