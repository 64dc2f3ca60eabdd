#include "engine/study/results/series.h"

#include "engine/study/conduct/sequence.h"

#include <charconv>
#include <utility>

namespace springdrive::study {

namespace {

/// From 0; tracks are stored by their number from 1, a single one without.
int track_index(const std::string &name) {
    int number = 1;
    std::from_chars(name.data(), name.data() + name.size(), number);
    return number - 1;
}

void add_trial(const Protocol &protocol, Series &series, const Trial &trial) {
    if (trial.is_practice) {
        return;
    }
    if (trial.is_catch) {
        series.catch_trials += trial.marks.empty() ? 1 : 0;
        series.catch_right += trial.marks.empty() && outcome_of(protocol, trial).positive ? 1 : 0;
        return;
    }
    if (series.runs.empty() || series.runs.back().block != trial.place.block) {
        series.runs.push_back({trial.place.block, {}});
    }
    series.runs.back().trials.push_back(trial);
}

} // namespace

std::vector<Series> series_of(const Protocol &protocol, const StudyContents &contents,
                              DeviceKind device) {
    const std::vector<Trial> trials = trials_on(contents, device);
    std::vector<Series> all;
    for (const Participant &participant : contents.participants) {
        for (std::size_t i = 0; i < protocol.conditions.size(); ++i) {
            Series series{participant.code, participant.number, i, {}, 0, 0};
            for (const Trial &trial : trials) {
                if (trial.participant == participant.code &&
                    trial.condition == protocol.conditions[i].name) {
                    add_trial(protocol, series, trial);
                }
            }
            if (!series.runs.empty()) {
                all.push_back(std::move(series));
            }
        }
    }
    return all;
}

PastMethodTrial method_trial(const Protocol &protocol, const Trial &trial) {
    return {{trial.level.value_or(0.0), track_index(trial.track)}, outcome_of(protocol, trial)};
}

std::vector<PastMethodTrial> counting_trials(const Protocol &protocol, const Series &series) {
    std::vector<PastMethodTrial> trials;
    for (const MethodTrials &run : series.runs) {
        for (const Trial &trial : run.trials) {
            if (counts(trial)) {
                trials.push_back(method_trial(protocol, trial));
            }
        }
    }
    return trials;
}

} // namespace springdrive::study
