#include "app/visitors/curve_of_answers.h"

#include "engine/study/protocol/session_plan.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <variant>
#include <vector>

namespace springdrive::app::visitors {

namespace {

constexpr std::array kTicks_deg{1.0, 2.0, 5.0, 10.0, 20.0, 30.0, 60.0, 90.0};
/// So near to an end of what is thought possible, an interval is open there: within a cell of the
/// usual grids.
constexpr double kEnd = 1.05;

struct Levels {
    double lowest;
    double highest;
};

Levels levels_of(const study::Protocol &protocol) {
    const std::vector<double> levels = study::presentable_levels(protocol);
    const auto [lowest, highest] = std::ranges::minmax(levels);
    return {lowest, highest};
}

} // namespace

std::string validate_for_visitors(const study::Protocol &protocol) {
    if (!study::is_forced_choice(protocol.task.kind) ||
        std::holds_alternative<study::Adjustment>(protocol.method)) {
        return "is no forced choice, of which a visitor's own curve could be drawn; name another "
               "protocol";
    }
    if (protocol.conditions.size() != 1) {
        return "has more than one condition, which visitors have no time for; leave one";
    }
    if (protocol.noise) {
        return "plays a masking noise, which nobody is there to turn down; remove its [noise]";
    }
    if (!protocol.questionnaire.empty()) {
        return "asks questions, whose answers would not be kept; remove its [[questions]]";
    }
    if (protocol.variable.parameter != "turn_deg" ||
        study::analysis_family(protocol).scale != study::Scale::logarithmic ||
        levels_of(protocol).lowest <= 0.0) {
        return "does not vary turn_deg on a logarithmic scale, which the words on the screen are "
               "for; name another protocol";
    }
    return {};
}

std::optional<study::SeriesResult> result_of_visit(const study::Protocol &protocol,
                                                   const study::StudyContents &visit) {
    if (visit.sessions.empty()) {
        return std::nullopt;
    }
    std::vector<study::Series> series =
        study::series_of(protocol, visit, visit.sessions.front().device);
    if (series.empty() || study::counting_trials(protocol, series.front()).empty()) {
        return std::nullopt;
    }
    return study::result_of(protocol, std::move(series.front()));
}

study_screen::OwnCurve curve_of(const study::Protocol &protocol,
                                const std::optional<study::SeriesResult> &result) {
    const Levels levels = levels_of(protocol);
    study_screen::OwnCurve curve;
    curve.lowest_level = levels.lowest;
    curve.highest_level = levels.highest;
    curve.guess = 1.0 / protocol.task.alternatives;
    std::ranges::copy_if(kTicks_deg, std::back_inserter(curve.ticks), [&](double tick) {
        return tick >= curve.lowest_level && tick <= curve.highest_level;
    });
    curve.level_label = "how far the force was turned (degrees)";
    curve.share_label = "right answers";
    if (!result) {
        return curve;
    }
    for (const study::LevelCount &count : result->counts) {
        curve.dots.push_back(
            {count.level, static_cast<double>(count.positive) / count.trials, count.trials});
    }
    if (result->fitted) {
        for (const study::FunctionPoint &point : result->fitted->course) {
            curve.course.push_back({point.level, point.proportion, point.low, point.high});
        }
        const study::PosteriorSummary &threshold = result->fitted->threshold;
        curve.threshold = {threshold.median, threshold.low, threshold.high};
    }
    return curve;
}

std::string threshold_words(const study_screen::OwnCurve &curve) {
    if (!curve.threshold) {
        return {};
    }
    const study_screen::OwnCurve::Threshold &threshold = *curve.threshold;
    if (threshold.high * kEnd >= curve.highest_level) {
        return fmt::format("more than {:.0f} degrees", threshold.low);
    }
    if (threshold.low <= kEnd * curve.lowest_level) {
        return fmt::format("less than {:.0f} degrees", threshold.high);
    }
    return fmt::format("{:.0f} degrees ({:.0f} to {:.0f})", threshold.level, threshold.low,
                       threshold.high);
}

} // namespace springdrive::app::visitors
