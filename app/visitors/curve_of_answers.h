// What a visitor's answers say, for the screen.
#pragma once

#include "app/study/participant/own_curve.h"
#include "engine/study/protocol/protocol.h"
#include "engine/study/results/study_results.h"
#include "engine/study/store/study_contents.h"

#include <optional>
#include <string>

namespace springdrive::app::visitors {

/// Why a protocol is no task for visitors, in a line with what to do; empty when it is one: one
/// condition, a forced choice about an angle on a logarithmic scale, no questions.
[[nodiscard]] std::string validate_for_visitors(const study::Protocol &protocol);

// @pre of the following: the protocol is a task for visitors

/// The fit of the only participant's trials; nothing before the first one that counts.
[[nodiscard]] std::optional<study::SeriesResult> result_of_visit(const study::Protocol &protocol,
                                                                 const study::StudyContents &visit);

/// Axes, and what `result` has of dots and fit.
[[nodiscard]] study_screen::OwnCurve curve_of(const study::Protocol &protocol,
                                              const std::optional<study::SeriesResult> &result);

/// "14 degrees (9 to 22)"; where the interval reaches an end of what was presented, "less than 4
/// degrees" or "more than 38 degrees".
[[nodiscard]] std::string threshold_words(const study_screen::OwnCurve &curve);

} // namespace springdrive::app::visitors
