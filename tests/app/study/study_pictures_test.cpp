// Covers app/study/sitting/{sitting,trial_presenter}.cpp: what a participant sees of a stimulus
// does not tell which it is. See same_pixels_test.cpp for what is drawn of it.
#include "engine/study/protocol/protocol_file.h"
#include "tests/app/study/made_up_people.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <string>
#include <vector>

namespace springdrive::app::study_screen {
namespace {

using study::PlannedTrial;

/// All that a participant sees of the first interval until the hand leaves.
std::vector<ParticipantPicture> pictures_of_first_interval(const study::Protocol &protocol,
                                                           const study::ProtocolFolders &folders,
                                                           const PlannedTrial &planned) {
    std::vector<ParticipantPicture> pictures;
    const auto note = [&](MadeUpPort &port) {
        port.on_frame = [&](const ParticipantPicture &picture, const SittingState &state) {
            if (state.step != SittingStep::interval || state.interval != 0) {
                return;
            }
            if (state.phase == study::StimulusPhase::leaving) {
                ParticipantPicture expected = pictures.back(); // for as long as a hand was deep
                expected.text = protocol.stimulus == study::StimulusForm::stroke
                                    ? ""
                                    : protocol.texts.please_lift;
                ASSERT_EQ(picture, expected);
            } else {
                pictures.push_back(picture);
            }
        };
    };
    present_alone(protocol, folders, planned, note, {}, [](const SittingState &state) {
        return state.step == SittingStep::between_intervals || state.step == SittingStep::response;
    });
    return pictures;
}

TEST(StudyPictures, AreTheSameOfEachConditionAndLevelUntilTheHandLeaves) {
    const study::ProtocolFolders folders{testing::assets() / "protocols", testing::assets()};
    for (const char *name : {"direction", "stiffness", "blow", "hardness", "mass"}) {
        SCOPED_TRACE(name);
        study::Protocol protocol = study::read_protocol_file(testing::assets() / "protocols" /
                                                             (std::string(name) + ".toml"));
        protocol.timing.response_s = 1.0;
        const std::vector<double> levels = study::presentable_levels(protocol);
        std::vector<ParticipantPicture> first;
        std::vector<PlannedTrial> all =
            trials_of_conditions(protocol, {levels.front(), levels.back()}, {0});
        // Another interval is the standard, of which no level is presented; another place is not.
        std::vector<double> levels_of_other{levels.back()};
        if (protocol.task.kind == study::TaskKind::forced_choice_by_place) {
            levels_of_other.push_back(levels.front());
        }
        std::ranges::move(trials_of_conditions(protocol, levels_of_other, {1}),
                          std::back_inserter(all));
        for (const PlannedTrial &planned : all) {
            SCOPED_TRACE(::testing::Message() << planned.condition << " at " << *planned.level
                                              << ", target " << *planned.target);
            const std::vector<ParticipantPicture> pictures =
                pictures_of_first_interval(protocol, folders, planned);
            EXPECT_GT(pictures.size(), 10U);
            if (first.empty()) {
                first = pictures;
            }
            ASSERT_EQ(pictures.size(), first.size());
            for (std::size_t i = 0; i < pictures.size(); ++i) {
                ASSERT_EQ(pictures[i], first[i]) << "frame " << i;
            }
        }
    }
}

} // namespace
} // namespace springdrive::app::study_screen
