// A whole study of one participant without windows and without a device, and whether another one
// came to the same.
#pragma once

#include "engine/study/conduct/conduct.h"
#include "engine/study/store/study_store.h"

#include <gtest/gtest.h>

#include <functional>
#include <optional>

namespace springdrive::testing {

/// The contents after a session that is run to its end.
/// @param number  of the participant, whose code is P01
inline study::StudyContents
conducted(const study::Protocol &protocol,
          const std::function<std::optional<study::Trial>(const study::PlannedTrial &)> &present,
          int number = 1) {
    study::StudyStore store =
        study::StudyStore::in_memory({protocol.title, "text", "0.1.0"}, study::utc_now());
    store.add({"P01", number, study::utc_now()});
    study::Session session;
    session.participant = "P01";
    session.started = study::utc_now();
    session.software = "0.1.0";
    session.id = store.begin(session);
    study::Conduct how;
    how.present = present;
    how.ends = [] { return std::nullopt; };
    EXPECT_EQ(study::conduct(store, protocol, session, how), study::SessionEnding::completed);
    return store.contents();
}

/// All of a trial that follows from the protocol and from what was answered before and in it.
inline void expect_same_decision(const study::Trial &seen, const study::Trial &requested) {
    SCOPED_TRACE(text_of(requested.place));
    EXPECT_EQ(seen.place, requested.place);
    EXPECT_EQ(seen.condition, requested.condition);
    EXPECT_EQ(seen.track, requested.track);
    EXPECT_EQ(seen.is_practice, requested.is_practice);
    EXPECT_EQ(seen.is_catch, requested.is_catch);
    EXPECT_EQ(seen.is_presented_again, requested.is_presented_again);
    EXPECT_EQ(seen.seed, requested.seed);
    EXPECT_EQ(seen.level_name, requested.level_name);
    EXPECT_EQ(seen.level, requested.level);
    EXPECT_EQ(seen.target, requested.target);
    EXPECT_EQ(seen.response, requested.response);
    EXPECT_EQ(seen.is_correct, requested.is_correct);
    EXPECT_EQ(seen.repetition_of, requested.repetition_of);
    EXPECT_EQ(seen.repeated_by, requested.repeated_by);
    if (requested.safety_events
            .empty()) { // else what was delivered until a stop may be marked, too
        EXPECT_EQ(seen.marks, requested.marks);
    }
}

} // namespace springdrive::testing
