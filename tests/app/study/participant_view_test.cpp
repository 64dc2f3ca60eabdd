// Covers app/study/participant/{participant_view,participant_scene}.cpp; and what a participant
// sees of a stimulus, by app/study/session/{session,trial_presenter}.cpp, which must not tell which
// it is: as pictures, and as pixels until the response, the same of each condition, level and order
// of the included protocols, each with its own scene and spot. Software OpenGL draws the same
// picture twice to the same bytes, so they are compared byte by byte; as many frames are drawn of
// each, and each by as many draw calls.
//
// `tests/long study-pixels` takes minutes; the sample is one protocol at its highest level.
#include "app/study/participant/participant_view.h"
#include "app/view/gl_objects.h"
#include "engine/scene/gltf.h"
#include "engine/study/protocol/protocol.h"
#include "tests/app/study/made_up_people.h"
#include "tests/app/study/participant_pictures.h"
#include "tests/support/cases.h"
#include "tests/support/devices.h"
#include "tests/support/hidden_window.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

namespace springdrive::app::study_screen {
namespace {

class ParticipantPixels : public ::testing::Test {
protected:
    static void SetUpTestSuite() { hidden_window = std::make_unique<testing::HiddenWindow>(); }
    static void TearDownTestSuite() { hidden_window.reset(); }

    static std::vector<std::uint8_t> drawn(const ParticipantPicture &picture) {
        ParticipantView view;
        view.draw(picture, 640, 360);
        return view.pixels();
    }

    inline static std::unique_ptr<testing::HiddenWindow> hidden_window;
};

TEST_F(ParticipantPixels, ShowLettersOfEveryAlphabetAndABoxForOthers) {
    const auto of_text = [](const char *text) {
        ParticipantPicture picture;
        picture.heading = text;
        return drawn(picture);
    };
    const auto nothing = of_text("");
    const auto box = of_text("漢");
    EXPECT_NE(box, nothing);
    EXPECT_EQ(box, of_text("字")); // the font lacks both
    for (const char *letter : {"ä", "ß", "Ω", "Ж"}) {
        const auto seen = of_text(letter);
        EXPECT_NE(seen, box) << letter;
        EXPECT_NE(seen, nothing) << letter;
    }
}

TEST_F(ParticipantPixels, AreThoseOfThePictureWhateverWasDrawnBefore) {
    ParticipantView used;
    for (const auto &[name, picture] : pictures_of_a_session()) {
        if (picture.scene == SceneShown::nothing) { // with one see below
            used.draw(picture, 640, 360);
            EXPECT_EQ(used.pixels(), drawn(picture)) << name;
        }
    }
    ParticipantPicture picture = picture_of_a_session("question");
    used.draw(picture, 1280, 720); // another size, and back
    picture.progress = 0.0;
    used.draw(picture, 640, 360);
    const auto at_start = drawn(picture);
    EXPECT_EQ(used.pixels(), at_start);
    picture.progress = 1.0;
    const auto at_end = drawn(picture);
    EXPECT_NE(at_end, at_start);
    picture.progress = 0.5;
    const auto halfway = drawn(picture);
    EXPECT_NE(halfway, at_start);
    EXPECT_NE(halfway, at_end);
}

TEST_F(ParticipantPixels, OfTheSceneShowBallAndRingAndAreTheSameEachTime) {
    const scene::Scene card =
        scene::load_gltf(std::string(SPRINGDRIVE_ASSET_DIR) + "/scenes/plate.gltf",
                         testing::phantom_1_0().workspace);
    const Vector3 middle_m = 0.5 * (card.lower_m + card.upper_m);
    const scene::TouchSpot spot{{middle_m.x(), card.upper_m.y(), middle_m.z()}, Vector3::UnitY()};
    const scene::TouchSpot aside{spot.point_m + Vector3(0.01, 0.0, 0.0), Vector3::UnitY()};
    ParticipantPicture picture = picture_of_a_session("scene");
    picture.tip_m = spot.point_m + Vector3(0.0, 0.012, 0.0);
    ParticipantPicture without_ball = picture;
    without_ball.tip_m.reset();
    const auto seen = [&](ParticipantView &view, const ParticipantPicture &one,
                          const scene::TouchSpot &at) {
        view.set_scene(card, at, -0.1);
        view.draw(one, 640, 360);
        return view.pixels();
    };
    ParticipantView view;
    ParticipantView other;
    const auto with_ball = seen(view, picture, spot);
    EXPECT_NE(seen(view, without_ball, spot), with_ball);
    EXPECT_EQ(seen(other, picture, spot), with_ball);
    EXPECT_NE(seen(other, picture, aside), with_ball);
}

using study::PlannedTrial;

/// All that a participant sees of the first interval until the hand leaves.
std::vector<ParticipantPicture> pictures_of_first_interval(const study::Protocol &protocol,
                                                           const study::ProtocolFolders &folders,
                                                           const PlannedTrial &planned) {
    std::vector<ParticipantPicture> pictures;
    const auto note = [&](MadeUpPort &port) {
        port.on_frame = [&](const ParticipantPicture &picture, const StudySessionState &state) {
            if (state.step != StudySessionStep::interval || state.interval != 0) {
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
    present_alone(protocol, folders, planned, note, {}, [](const StudySessionState &state) {
        return state.step == StudySessionStep::between_intervals ||
               state.step == StudySessionStep::response;
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

struct Frame {
    std::vector<std::uint8_t> pixels;
    int draw_calls = 0;       ///< the work that a frame's duration could tell of
    std::size_t vertices = 0; ///< the same, of all but the scene
    bool operator==(const Frame &) const = default;
};

bool is_all() { return testing::cases(0, 1) == 1; }

/// Frames of the first interval until the hand leaves, and each other picture once until the
/// response: how long a hand is on its way says how deep it was, to whom it belongs.
std::vector<Frame> frames_of(const study::Protocol &protocol, const study::ProtocolFolders &folders,
                             const study::PlannedTrial &planned) {
    ParticipantView view(0);
    const double floor_m = -0.09; // of any workspace: the same for all
    std::vector<Frame> frames;
    ParticipantPicture last;
    present_alone(protocol, folders, planned, [&](MadeUpPort &port) {
        port.on_scene = [&](const scene::Scene &scene, const scene::TouchSpot &spot) {
            view.set_scene(scene, spot, floor_m);
        };
        port.on_frame = [&](const ParticipantPicture &picture, const StudySessionState &state) {
            const bool is_way_back = state.phase == study::StimulusPhase::leaving;
            const bool is_first = state.step == StudySessionStep::interval && state.interval == 0;
            const bool is_still = state.step == StudySessionStep::between_intervals ||
                                  state.step == StudySessionStep::response;
            if ((is_first && !is_way_back) || ((is_first || is_still) && picture != last)) {
                const int calls = draw_calls();
                const std::size_t vertices = view.vertices();
                view.draw(picture, is_all() ? 640 : 320, is_all() ? 360 : 180);
                frames.push_back({view.pixels(), draw_calls() - calls, view.vertices() - vertices});
            }
            last = picture;
        };
    });
    return frames;
}

TEST(StudyPixels, AreTheSameOfEachConditionLevelAndOrderUntilTheResponse) {
    const testing::HiddenWindow window;
    const study::ProtocolFolders folders{testing::assets() / "protocols", testing::assets()};
    std::size_t compared = 0;
    const std::vector<std::string> names =
        is_all() ? std::vector<std::string>{"direction", "stiffness", "blow", "hardness", "mass"}
                 : std::vector<std::string>{"stiffness"};
    for (const std::string &name : names) {
        SCOPED_TRACE(name);
        study::Protocol protocol =
            study::read_protocol_file(testing::assets() / "protocols" / (name + ".toml"));
        protocol.timing.response_s = 1.0;
        const std::vector<double> all = study::presentable_levels(protocol);
        const std::vector<double> levels =
            is_all() ? std::vector<double>{all.front(), all.back()} : std::vector{all.back()};
        std::vector<Frame> first;
        for (const study::PlannedTrial &planned : trials_of_conditions(protocol, levels, {0, 1})) {
            SCOPED_TRACE(::testing::Message() << planned.condition << " at " << *planned.level);
            const std::vector<Frame> frames = frames_of(protocol, folders, planned);
            if (first.empty()) {
                first = frames;
                EXPECT_GT(frames.size(), 10U);
                EXPECT_NE(frames.front().pixels, frames.back().pixels); // something is seen
            }
            ASSERT_EQ(frames.size(), first.size());
            for (std::size_t i = 0; i < frames.size(); ++i) {
                ASSERT_TRUE(frames[i] == first[i]) << "frame " << i;
            }
            compared += frames.size();
        }
    }
    std::printf("counts: %zu frames of %zu protocols, byte by byte\n", compared, names.size());
}

} // namespace
} // namespace springdrive::app::study_screen
