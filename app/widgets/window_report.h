// What the window shows, as data: every widget with its place, text and value, for tests and
// scripts.
//
//   widgets ──► enter() ──► WindowReport ──► json(), one line, on request
#pragma once

#include "app/widgets/rectangle.h"
#include "engine/servo/duration_histogram.h"
#include "engine/servo/servo_sample.h"

#include <cstdint>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace springdrive::app {

/// One widget in one frame.
struct ShownItem {
    std::string id;   ///< panel, scopes and label, from outside in: "Tuning/Gains/K_P/slider"
    std::string kind; ///< "button", "text", "slider", …
    std::string text; ///< as shown
    std::variant<std::monostate, bool, double, std::string> value;
    std::vector<std::pair<std::string, double>> numbers; ///< further ones, for example of a plot
    Rectangle place;        ///< in the window's units; what is seen of it
    bool is_visible = true; ///< not scrolled out of its panel
    bool is_enabled = true;
    bool is_focused = false; ///< keys act on it
    bool overflows = false;  ///< wider than its panel
};

/// Collects the items of a frame, if they are wanted.
class WindowReport {
public:
    /// Begins a frame.
    void begin(bool is_wanted) {
        is_wanted_ = is_wanted;
        items_.clear();
    }
    [[nodiscard]] bool is_wanted() const { return is_wanted_; }

    void enter(ShownItem item) { items_.push_back(std::move(item)); }
    void note_focus() { items_.back().is_focused = true; } ///< on the last one
    [[nodiscard]] const std::vector<ShownItem> &items() const { return items_; }

private:
    bool is_wanted_ = false;
    std::vector<ShownItem> items_;
};

/// The window itself, beside its items.
struct WindowFacts {
    std::uint64_t frame = 0;
    float width = 0.0F;
    float height = 0.0F;
    float scale = 1.0F;
    double frame_median_s = 0.0; ///< time to compute and draw a frame
    double frame_p99_s = 0.0;
};

/// @param durations  of its frames
[[nodiscard]] WindowFacts facts_of(std::uint64_t frame, int width, int height, float scale,
                                   const servo::DurationHistogram &durations);

/// One line of JSON: `window`, `items`, and `sample`, the servo's latest sample by telemetry
/// column.
[[nodiscard]] std::string json_line(const WindowReport &report, const WindowFacts &window,
                                    const servo::ServoSample &sample);

} // namespace springdrive::app
