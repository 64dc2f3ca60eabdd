#include "engine/study/methods/quest_plus.h"

#include "engine/study/methods/wrong_value.h"

namespace springdrive::study {

std::string what_is_wrong_with(const QuestPlus &method) {
    const bool ratios = method.family.scale == Scale::logarithmic;
    constexpr double kMostPoints = 1000.0;
    if (std::string complaint =
            first_of({unless_rising("levels", method.levels, 2),
                      ratios && !method.levels.empty()
                          ? unless_above("levels (each)", method.levels.front(), 0.0)
                          : std::string(),
                      what_is_wrong_with(method.threshold.prior, "threshold"),
                      what_is_wrong_with(method.slope.prior, "slope"),
                      what_is_wrong_with(method.guess.prior, "guess"),
                      what_is_wrong_with(method.lapse.prior, "lapse"),
                      unless_from_to("threshold.points", method.threshold.points, 2, kMostPoints),
                      unless_from_to("slope.points", method.slope.points, 1, kMostPoints),
                      unless_from_to("guess.points", method.guess.points, 1, kMostPoints),
                      unless_from_to("lapse.points", method.lapse.points, 1, kMostPoints)});
        !complaint.empty()) {
        return complaint;
    }
    const double cells = static_cast<double>(method.levels.size()) * method.threshold.points *
                         method.slope.points * method.guess.points * method.lapse.points;
    return first_of({ratios ? unless_above("threshold.minimum", method.threshold.prior.minimum, 0.0)
                            : std::string(),
                     unless_above("slope.minimum", method.slope.prior.minimum, 0.0),
                     unless_from_to("guess.minimum", method.guess.prior.minimum, 0.0, 1.0),
                     unless_from_to("guess.maximum", method.guess.prior.maximum, 0.0, 1.0),
                     unless_from_to("lapse.minimum", method.lapse.prior.minimum, 0.0, 1.0),
                     unless_from_to("lapse.maximum", method.lapse.prior.maximum, 0.0,
                                    1.0 - method.guess.prior.maximum),
                     unless_from_to("levels times all points", cells, 1.0, kLargestQuestTable),
                     unless_from_to("most_trials", method.most_trials, 1, 10000),
                     unless_from_to("fewest_trials", method.fewest_trials, 1, method.most_trials),
                     unless_from_to("threshold_deviation", method.threshold_deviation, 0.0, 1e6)});
}

} // namespace springdrive::study
