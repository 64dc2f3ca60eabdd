// A whole study of one participant without windows and without a device.
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

} // namespace springdrive::testing
