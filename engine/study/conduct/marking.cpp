#include "engine/study/conduct/marking.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <variant>

namespace springdrive::study {

namespace {

/// "3.1 % off, more than 2 %"; empty within the band.
std::string off_by_more(double off, double most, std::string_view unit) {
    return off <= most ? std::string()
                       : fmt::format("{:.3g}{} off, more than {:g}{}", off, unit, most, unit);
}

std::string share_off_by_more(double delivered, double intended, double max_percent) {
    return off_by_more(100.0 * std::abs(delivered - intended) / std::abs(intended), max_percent,
                       " %");
}

std::string error_text_of(const Marking &marking, Band band, const StimulusValue &value) {
    if (!value.intended) {
        return {};
    }
    if (!value.delivered) {
        return "was not measured";
    }
    switch (band) {
    case Band::direction:
        return off_by_more(std::abs(*value.delivered - *value.intended), marking.direction_deg,
                           "°");
    case Band::stiffness:
        return share_off_by_more(*value.delivered, *value.intended, marking.stiffness_percent);
    case Band::force:
        return share_off_by_more(*value.delivered, *value.intended, marking.force_percent);
    case Band::lateness:
        break;
    }
    return off_by_more(*value.delivered, marking.lateness_s, " s");
}

} // namespace

std::vector<std::string> marks_of(const Marking &marking,
                                  std::span<const Presentation> presentations) {
    std::vector<std::string> marks;
    for (std::size_t i = 0; i < presentations.size(); ++i) {
        for (const StimulusValue &value : presentations[i].values) {
            const auto known = std::ranges::find(kMeasuredValues, value.name, &MeasuredValue::name);
            if (known == kMeasuredValues.end()) {
                continue;
            }
            const std::string error = error_text_of(marking, known->band, value);
            if (!error.empty()) {
                marks.push_back(fmt::format("{} of presentation {}: {}", value.name, i + 1, error));
            }
        }
    }
    return marks;
}

bool comes_again(const Marking &marking, const std::vector<std::string> &marks,
                 const Response &response) {
    return !marks.empty() && (marking.repeats || std::holds_alternative<NoResponse>(response));
}

} // namespace springdrive::study
