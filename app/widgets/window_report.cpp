#include "app/widgets/window_report.h"

#include "base/text.h"
#include "engine/record/telemetry_columns.h"

#include <nlohmann/json.hpp>

#include <string_view>
#include <type_traits>

namespace springdrive::app {

namespace {

using nlohmann::json;

json json_of(const ShownItem &item) {
    json shown{{"id", item.id},
               {"kind", item.kind},
               {"text", item.text},
               {"x", item.place.corner.x},
               {"y", item.place.corner.y},
               {"width", item.place.size.x},
               {"height", item.place.size.y}};
    std::visit(
        [&shown](const auto &value) {
            if constexpr (!std::is_same_v<std::decay_t<decltype(value)>, std::monostate>) {
                shown["value"] = value;
            }
        },
        item.value);
    for (const auto &[name, number] : item.numbers) {
        shown["numbers"][name] = number;
    }
    // Only what is out of the ordinary.
    if (!item.is_visible) {
        shown["visible"] = false;
    }
    if (!item.is_enabled) {
        shown["enabled"] = false;
    }
    if (item.is_focused) {
        shown["focused"] = true;
    }
    if (item.overflows) {
        shown["overflows"] = true;
    }
    return shown;
}

/// Enums as numbers, as in exported records.
template <typename Value> json number_of(const Value &value) {
    if constexpr (std::is_enum_v<Value>) {
        return static_cast<int>(value);
    } else {
        return value;
    }
}

json json_of(const servo::ServoSample &sample) {
    json columns = json::object();
    record::for_each_column(sample,
                            [&columns](std::string_view name, std::string_view, const auto &value) {
                                columns[std::string(name)] = number_of(value);
                            });
    return columns;
}

} // namespace

WindowFacts facts_of(std::uint64_t frame, int width, int height, float scale,
                     const servo::DurationHistogram &durations) {
    return {frame, static_cast<float>(width), static_cast<float>(height),
            scale, durations.quantile_s(0.5), durations.quantile_s(0.99)};
}

std::string json_line(const WindowReport &report, const WindowFacts &window,
                      const servo::ServoSample &sample) {
    json items = json::array();
    for (const ShownItem &item : report.items()) {
        items.push_back(json_of(item));
    }
    const json all{{"window",
                    {{"frame", window.frame},
                     {"width", window.width},
                     {"height", window.height},
                     {"scale", window.scale},
                     {"frame_median_s", window.frame_median_s},
                     {"frame_p99_s", window.frame_p99_s}}},
                   {"items", std::move(items)},
                   {"sample", json_of(sample)}};
    return json_text(all, -1);
}

} // namespace springdrive::app
