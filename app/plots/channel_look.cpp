#include "app/plots/channel_look.h"

#include "app/plots/symbols.h"
#include "app/widgets/widgets.h"
#include "base/degrees.h"
#include "engine/control/perception.h"
#include "engine/session/telemetry_history.h"

#include <algorithm>
#include <array>
#include <limits>
#include <vector>

namespace springdrive::app {

namespace {

/// Channels whose look has a meaning. Solid lines are measured and so include the plant; dashed
/// ones are what the map alone would do, at rest and without any plant.
struct NamedLook {
    std::string_view channel;
    std::string_view label;
    Stroke stroke;
};

const std::array<NamedLook, 8> &named_looks() {
    static const std::array<NamedLook, 8> looks{{
        {"transpose_error_rad", "transpose, ideal", {kTransposeMap, 1.6F, Dash::dashed}},
        {"inverse_error_rad", "inverse, ideal", {kInverseMap, 1.6F, Dash::dashed}},
        {"transpose_measured_rad", "transpose, measured", {kTransposeMap, 2.0F}},
        {"inverse_measured_rad", "inverse, measured", {kInverseMap, 2.0F}},
        {"rendered_error_rad", "every tick", {ImVec4(0.62F, 0.65F, 0.69F, 0.45F), 1.0F}},
        {"force_N", "force", {kForce, 2.0F}},
        {"force_outward_N", "force outward", {kForce, 2.0F, Dash::dashed}},
        {"force_up_N", "force up", {kForce, 2.0F, Dash::dotted}},
    }};
    return looks;
}

/// Told apart also by most of those who do not see red or green as others do: they differ in
/// lightness as well.
constexpr std::size_t kColourCount = 7;
const std::array<ImVec4, kColourCount> kColours{{{0.17F, 0.78F, 0.60F, 1.0F},
                                                 {0.93F, 0.78F, 0.20F, 1.0F},
                                                 {0.90F, 0.55F, 0.85F, 1.0F},
                                                 {0.86F, 0.88F, 0.90F, 1.0F},
                                                 {0.66F, 0.62F, 0.98F, 1.0F},
                                                 {0.72F, 0.64F, 0.48F, 1.0F},
                                                 {0.62F, 0.86F, 0.35F, 1.0F}}};

/// Which of three, if a channel belongs to a motor or is a component of a vector: the place of the
/// digit or letter that says so in its label.
struct Component {
    std::size_t index;
    std::string of; ///< the label without it
};

std::optional<Component> component_of(const std::string &label) {
    constexpr std::string_view kLetters = "xyz";
    for (std::size_t i = 0; i < label.size(); ++i) {
        const bool is_alone =
            i > 0 && label[i - 1] == '_' && (i + 1 == label.size() || label[i + 1] == '_');
        const std::size_t letter = kLetters.find(label[i]);
        if (is_alone && letter != std::string_view::npos) {
            return Component{letter, label.substr(0, i) + label.substr(i + 1)};
        }
        if (label[i] >= '1' && label[i] <= '3') {
            return Component{static_cast<std::size_t>(label[i] - '1'),
                             label.substr(0, i) + label.substr(i + 1)};
        }
    }
    return std::nullopt;
}

/// The same motor, or the same direction, has the same colour in all quantities, which differ in
/// their dashes; all others have the other colours.
std::vector<ChannelLook> all_looks() {
    std::vector<ChannelLook> looks;
    std::vector<std::string> vectors;
    std::size_t scalars = 0;
    constexpr std::size_t kOthers = kColourCount - 3;
    for (const session::Channel &channel : session::channels()) {
        const auto named = std::ranges::find(named_looks(), channel.name, &NamedLook::channel);
        const std::string label = without_unit(channel); // it stands at the axis
        if (named != named_looks().end()) {
            looks.push_back({std::string(named->label), named->stroke});
        } else if (const std::optional<Component> component = component_of(label)) {
            if (std::ranges::find(vectors, component->of) == vectors.end()) {
                vectors.push_back(component->of);
            }
            const auto group = std::ranges::find(vectors, component->of) - vectors.begin();
            looks.push_back(
                {label, {kColours[component->index], 1.6F, static_cast<Dash>(group % 3)}});
        } else {
            looks.push_back({label,
                             {kColours[3 + scalars % kOthers], 1.6F,
                              static_cast<Dash>(scalars / kOthers % 3)}});
            ++scalars;
        }
    }
    return looks;
}

bool is_direction_error(std::size_t channel) {
    return session::channels()[channel].name.ends_with("error_rad") ||
           session::channels()[channel].name.ends_with("measured_rad");
}

} // namespace

const ChannelLook &look_of(std::size_t channel) {
    static const std::vector<ChannelLook> looks = all_looks();
    return looks.at(channel);
}

ShownUnit shown_unit(std::size_t channel, bool in_si) {
    const session::Channel &known = session::channels()[channel];
    const std::string_view si_unit = known.unit;
    struct Unit {
        std::string_view si;
        ShownUnit shown;
    };
    static constexpr std::array<Unit, 6> kUnits{{{"rad", {"°", kDegreesPerRadian}},
                                                 {"rad/s", {"°/s", kDegreesPerRadian}},
                                                 {"m", {"mm", 1e3}},
                                                 {"m/s", {"mm/s", 1e3}},
                                                 {"J", {"mJ", 1e3}},
                                                 {"A", {"mA", 1e3}}}};
    static constexpr std::array<std::string_view, 6> kDurations{
        "since_last_s", "lateness_s", "period_s", "read_s", "compute_s", "write_s"};
    if (!in_si && std::ranges::find(kDurations, known.name) != kDurations.end()) {
        return {"µs", 1e6};
    }
    const auto *const found = std::ranges::find(kUnits, si_unit, &Unit::si);
    if (in_si || found == kUnits.end()) {
        return {si_unit == "1" ? "–" : si_unit, 1.0};
    }
    return found->shown;
}

std::optional<PlotLevel> level_of(std::size_t channel) {
    if (is_direction_error(channel)) {
        return PlotLevel{control::kNoticeable_deg / kDegreesPerRadian, "25°: limit of perception"};
    }
    return std::nullopt;
}

double min_range_of_interest(std::size_t channel) {
    constexpr double kMinError_deg = 10.0;
    if (is_direction_error(channel)) {
        return kMinError_deg / kDegreesPerRadian;
    }
    struct Least {
        std::string_view unit;
        double range;
    };
    static constexpr std::array<Least, 8> kMin{{{"N", 1.0},
                                                {"V", 0.1},
                                                {"A", 0.02},
                                                {"m", 1e-3},
                                                {"m/s", 1e-2},
                                                {"rad", 1e-3},
                                                {"rad/s", 0.1},
                                                {"J", 1e-4}}};
    const auto *const found =
        std::ranges::find(kMin, session::channels()[channel].unit, &Least::unit);
    return found == kMin.end() ? 0.0 : found->range;
}

double greatest_of_interest(std::size_t channel) {
    constexpr double kMaxError_deg = 60.0;
    return is_direction_error(channel) ? kMaxError_deg / kDegreesPerRadian
                                       : std::numeric_limits<double>::infinity();
}

} // namespace springdrive::app
