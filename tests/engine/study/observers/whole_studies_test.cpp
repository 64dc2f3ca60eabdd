// Covers engine/study/observers as a whole: studies of participants whose function is known, in
// real study files, every presentation through the simulated device. One by default, 20 by
// tests/long.
#include "engine/study/analysis/posterior.h"
#include "engine/study/conduct/sequence.h"
#include "engine/study/observers/simulated_sitting.h"
#include "engine/study/store/database.h"
#include "tests/engine/study/protocol/plain_protocol.h"
#include "tests/support/cases.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <string>
#include <vector>

namespace springdrive::study {
namespace {

/// Force-direction discrimination as it is shipped, of one of its conditions, in 40 trials.
Protocol short_direction_protocol() {
    Protocol protocol = read_protocol_file(testing::assets() / "protocols" / "direction.toml");
    protocol.blocks = {{"one", {2}}};
    auto &method = std::get<QuestPlus>(protocol.method);
    method.min_trials = 40;
    method.max_trials = 40;
    protocol.practice = {};
    protocol.catch_trials = {};
    return protocol;
}

UtcTime some_time() {
    using namespace std::chrono;
    return UtcTime(sys_days(2026y / January / 1));
}

struct WholeStudy {
    SessionEnding ending = SessionEnding::failed;
    std::vector<Trial> trials;
};

/// From the first trial to the last, in a file.
WholeStudy whole_study(const Protocol &protocol, const StudySetting &setting,
                       const SimulatedParticipant &participant, const std::filesystem::path &file) {
    create_study(file, {protocol.title, "text", "0.1.0"}, some_time());
    DatabaseSettings without_waiting;
    without_waiting.synchronous = "OFF";
    StudyStore store(file, without_waiting);
    store.add({"P01", 1, some_time()});
    Session session;
    session.participant = "P01";
    session.started = some_time();
    session.software = "0.1.0";
    session.id = store.begin(session);
    SimulatedSitting sitting(protocol, setting, participant);
    Conduct how;
    how.present = [&sitting](const PlannedTrial &planned) { return sitting.present(planned); };
    how.ends = [] { return std::nullopt; };
    how.now = some_time;
    const SessionEnding ending = conduct(store, protocol, session, how);
    return {ending, store.contents().trials};
}

std::vector<PastMethodTrial> counting(const Protocol &protocol, const std::vector<Trial> &trials) {
    std::vector<PastMethodTrial> counted;
    for (const Trial &trial : trials) {
        if (counts(trial)) {
            counted.push_back({{*trial.level, 0}, outcome_of(protocol, trial)});
        }
    }
    return counted;
}

TEST(WholeStudies, GiveBackTheTruthOfTheirParticipants) {
    const Protocol protocol = short_direction_protocol();
    const StudySetting setting =
        study_setting(protocol, {testing::assets() / "protocols", testing::assets()});
    // What the method takes to be likely; the truths are drawn from it.
    const FunctionPriors priors = priors_of(std::get<QuestPlus>(protocol.method));
    const std::filesystem::path folder = testing::fresh_folder("whole_studies");
    const int studies = testing::cases(1, 20);
    int held = 0;
    std::size_t all_trials = 0;
    std::size_t marked = 0;
    for (int i = 0; i < studies; ++i) {
        const RandomKey key = child(RandomKey{20'260'101}, static_cast<std::uint64_t>(i));
        SimulatedParticipant participant;
        participant.function = drawn_function(priors, child(key, 0));
        participant.seed = key.bits;
        const WholeStudy study =
            whole_study(protocol, setting, participant, folder / ("study" + std::to_string(i)));
        EXPECT_EQ(study.ending, SessionEnding::completed);
        const std::vector<PastMethodTrial> trials = counting(protocol, study.trials);
        EXPECT_EQ(trials.size(), 40U);
        all_trials += study.trials.size();
        marked += study.trials.size() - trials.size();
        const PosteriorSummary threshold =
            Posterior(counted(trials), priors).of(FunctionParameter::threshold);
        held += threshold.low <= participant.function.threshold &&
                        participant.function.threshold <= threshold.high
                    ? 1
                    : 0;
    }
    std::printf("counts: %d of %d intervals of 95 %% hold the truth; %zu trials, %zu marked\n",
                held, studies, all_trials, marked);
    // Of 20 at 95 % fewer than 16 hold the truth once in 390 times; of one, this seed's does.
    EXPECT_GE(held, studies == 1 ? 1 : 16);
    EXPECT_LE(marked, all_trials / 20);
}

} // namespace
} // namespace springdrive::study
