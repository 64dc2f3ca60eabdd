// A small protocol of every kind of trial, and a participant and device without a will of their
// own: what is presented, answered and marked depends on the planned trial alone.
#pragma once

#include "base/input_error.h"
#include "engine/study/conduct/conduct.h"
#include "engine/study/methods/random_key.h"

#include <chrono>
#include <string>

namespace springdrive::study {

/// Two blocks of two conditions, by two interleaved staircases each, with practice and catch
/// trials.
inline Protocol small_protocol() {
    Protocol protocol;
    protocol.title = "Small";
    protocol.seed = 7;
    for (const char *name : {"soft", "hard", "wide", "narrow"}) {
        protocol.conditions.emplace_back().name = name;
    }
    protocol.variable.parameter = "eta";
    protocol.variable.level = LevelMeaning::added;
    protocol.variable.standard = 0.2;
    Staircases staircases;
    staircases.start_levels = {0.5, 0.1};
    staircases.minimum_level = 0.0;
    staircases.maximum_level = 0.7;
    staircases.steps = {{0, 0.1}, {2, 0.05}};
    staircases.reversals = 0;
    staircases.trials = 6;
    protocol.method = staircases;
    protocol.practice = {{0.6, 0.7}, 3, 2, 8};
    protocol.catch_trials = {{0.7}, 6};
    protocol.blocks = {{"first", {0, 1}}, {"second", {2, 3}}};
    protocol.counterbalancing = Counterbalancing::full;
    protocol.marking.max_marked = 50;
    protocol.stopping.max_trips = 1000;
    return protocol;
}

/// A tenth of the trials is out of its band, a twentieth trips, a twentieth is not answered; of the
/// others, those at high levels are mostly right.
inline Trial answer_to(const Protocol &protocol, const PlannedTrial &planned) {
    const auto draws = [&planned](std::uint64_t what, double share) {
        return uniform(child(RandomKey{planned.seed}, what)) < share;
    };
    Trial result(planned);
    Presentation shown;
    shown.start_s = uniform(child(RandomKey{planned.seed}, 0));
    shown.values = {{"stiffness_N_per_m", 1000.0, draws(1, 0.1) ? 1021.0 : 1019.0}};
    result.presentations.assign(static_cast<std::size_t>(presentations_per_trial(protocol)), shown);
    if (draws(2, 0.05)) {
        result.safety_events = {{0.5, "tip speed 2.1 m/s, at most 2 m/s"}};
    }
    if (!draws(3, 0.05)) {
        const bool knows = draws(4, 0.2 + *planned.level);
        const int right = *planned.target;
        result.response = Chosen{knows ? right : 3 - right};
        result.response_time_s = 0.3 + uniform(child(RandomKey{planned.seed}, 5));
    }
    result.tuning = {{"dR_Ohm", 0.5}, {"map", std::string("transpose")}};
    result.windings_degC = {31.0, std::nullopt, 33.0};
    return result;
}

/// Seconds since 2026-01-01, so that times are the same in each run.
inline UtcTime test_time(int second) {
    using namespace std::chrono;
    return UtcTime(sys_days(2026y / January / 1)) + seconds(second);
}

inline SessionId begin_session(StudyStore &store, const std::string &code) {
    Session session;
    session.participant = code;
    session.started = test_time(0);
    session.software = "0.1.0";
    return store.begin(session);
}

/// A store of that protocol with participants P01 and P02.
inline void create_small_study(const std::filesystem::path &file, const Protocol &protocol) {
    create_study(file, {protocol.title, "text of the protocol", "0.1.0"}, test_time(0));
    StudyStore store(file);
    store.add({"P01", 1, test_time(0)});
    store.add({"P02", 2, test_time(0)});
}

inline Session session_in(const StudyStore &store, SessionId id) {
    return session_of(store.contents(), id);
}

} // namespace springdrive::study
