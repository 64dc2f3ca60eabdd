// What all plots over time have in common: the time that is shown, whether it follows the present,
// and two cursors.
#pragma once

#include "app/plots/oscilloscope.h"
#include "engine/record/channel_store.h"

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace springdrive::app {

/// A live view ends at the newest tick, or where a record stands. A held one never moves by itself:
/// it keeps a snapshot, from which nothing is lost while the servo goes on.
class PlotView {
public:
    static constexpr double kMinSpan_s = 1e-4;
    static constexpr double kMaxSpan_s = 3600.0;

    [[nodiscard]] bool is_live() const { return held_ == nullptr; }
    /// Held, zoomed or moved by hand: no event may replace it.
    [[nodiscard]] bool is_held_by_hand() const { return held_by_hand_; }
    [[nodiscard]] double span_s() const { return span_s_; }
    /// What is shown now.
    [[nodiscard]] signals::TimeWindow window(const record::ChannelStore &live) const;
    [[nodiscard]] const record::ChannelStore &store(const record::ChannelStore &live) const {
        return held_ ? *held_ : live;
    }

    /// The snapshot of a held view: to be kept by who uses it for longer than until the next change
    /// of the view.
    [[nodiscard]] std::shared_ptr<const record::ChannelStore> held() const { return held_; }

    /// Follows again, with the span from before the view was zoomed.
    void go_live() {
        held_.reset();
        held_by_hand_ = false;
        span_s_ = chosen_span_s_;
    }
    /// What a live view ends at: this time of a record, or the newest tick.
    void follow(std::optional<double> time_s) { followed_s_ = time_s; }
    /// Stops the view where it is.
    void hold(const record::ChannelStore &live);
    /// Holds, and shows this window of an event.
    void show_event(const record::ChannelStore &live, const signals::TimeWindow &window);
    /// Holds, and zooms or moves to this window.
    void show(const record::ChannelStore &live, const signals::TimeWindow &requested);
    /// The end of what was shown before it was zoomed or moved: that of the event, or of the hold.
    [[nodiscard]] double reference_end_s(const record::ChannelStore &live) const {
        return is_live() ? window(live).to_s : reference_end_s_;
    }
    /// Chooses the span, with the same end.
    void set_span(double span_s);

    bool shows_cursors = false;
    std::array<double, 2> cursor_s{}; ///< in the store's time

    /// Places the cursors at a third and two thirds of what is shown.
    void place_cursors(const record::ChannelStore &live);

private:
    void zoom_to_span(double span_s);

    double chosen_span_s_ = 5.0;
    double span_s_ = 5.0; ///< as chosen, unless zoomed or that of an event
    bool held_by_hand_ = false;
    std::optional<double> followed_s_; ///< empty: the newest tick
    double end_s_ = 0.0;               ///< of a held view
    double reference_end_s_ = 0.0;
    std::shared_ptr<const record::ChannelStore> held_;
};

enum class TriggerSource : std::uint8_t { off, contact, trip, gain_change, level };

inline constexpr std::array<const char *, 5> kTriggerSourceLabels{"off", "contact", "trip",
                                                                  "gain change", "level"};
inline constexpr std::array<const char *, 4> kTriggerEdgeLabels{"rises above", "falls below",
                                                                "passes", "changes"};

struct PlotTriggerSettings {
    TriggerSource source = TriggerSource::off;
    // For TriggerSource::level.
    std::size_t channel = 0;
    signals::TriggerEdge edge = signals::TriggerEdge::rising;
    double level_si = 0.0;
    bool repeats = false;
    double pre_share = 0.25; ///< of the span, before the event

    friend bool operator==(const PlotTriggerSettings &, const PlotTriggerSettings &) = default;
};

class PlotTrigger {
public:
    /// Waits for the next event with these settings. @param span_s  that is shown
    void arm(const PlotTriggerSettings &settings, double span_s, const record::ChannelStore &live);

    /// Takes the rows since the last call, and shows the event once the time behind it is over.
    void advance(const record::ChannelStore &live, PlotView &view);

    [[nodiscard]] const PlotTriggerSettings &settings() const { return settings_; }
    /// For display: "armed", "collecting", "stopped at the event".
    [[nodiscard]] const char *state_text() const;

    std::string searched; ///< in the menu's list of channels

private:
    [[nodiscard]] bool fires(const record::ChannelStore &live, std::uint64_t row);

    struct Watch {
        std::size_t channel = 0;
        signals::EdgeDetector detector;
    };

    PlotTriggerSettings settings_;
    signals::Trigger trigger_{signals::TriggerSettings{}};
    std::vector<Watch> watches_; ///< any of them fires it
    std::uint64_t next_row_ = 0;
};

} // namespace springdrive::app
