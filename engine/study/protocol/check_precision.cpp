#include "engine/study/protocol/analysis_plan.h"
#include "engine/study/protocol/checks.h"

#include <fmt/core.h>

#include <cmath>
#include <string>

namespace springdrive::study {

ProtocolFindings check_precision(const Protocol &protocol) {
    if (!protocol.expected) {
        return {
            {Severity::note, "precision", "to be expected is not known without [expected]", ""}};
    }
    const PsychometricFunction observer = expected_observer(protocol);
    PrecisionQuestion question = precision_question(protocol, observer);
    question.studies = 60; // a median width to within some 5 %
    question.trials = {usual_trials(protocol, observer)};
    if (const std::string wrong = what_is_wrong_with(question, protocol.task); !wrong.empty()) {
        return {{Severity::warning, "precision", "cannot be reckoned: " + wrong,
                 "give [expected] a function that fits the method"}};
    }
    const Precision precision = precision_by_trials(question).front();
    const bool ratios = question.analysis.family.scale == Scale::logarithmic;
    const double width = ratios ? std::exp(precision.median_width) : precision.median_width;
    return {{Severity::note, "precision",
             fmt::format("a participant's threshold in a condition is known to within {} {:.3g} "
                         "(95 % interval, from end to end, in the median), with {} trials and "
                         "observers as expected",
                         ratios ? "a factor of" : "a width of", width, precision.trials),
             ""}};
}

} // namespace springdrive::study
