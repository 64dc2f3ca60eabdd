// Stops the plots at an event, as an oscilloscope does: a contact, a trip, a change of the tuning,
// or a channel that passes a level.
#pragma once

#include "app/plots/plot_view.h"
#include "app/plots/trigger.h"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace springdrive::app {

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
