// What a participant sees of a trial until the response, as pixels: the same of each condition,
// level and order of the included protocols, each with its own scene and spot. Software OpenGL
// draws the same picture twice to the same bytes, so they are compared byte by byte; as many frames
// are drawn of each, and each by as many draw calls.
//
// `tests/long study-pixels` takes minutes; the sample is one protocol at its highest level.
#include "app/study/participant/participant_view.h"
#include "app/view/gl_objects.h"
#include "tests/app/study/made_up_people.h"
#include "tests/support/cases.h"
#include "tests/support/hidden_window.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

namespace springdrive::app::study_screen {
namespace {

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
        port.on_frame = [&](const ParticipantPicture &picture, const SittingState &state) {
            const bool is_way_back = state.phase == study::StimulusPhase::leaving;
            const bool is_first = state.step == SittingStep::interval && state.interval == 0;
            const bool is_still =
                state.step == SittingStep::between_intervals || state.step == SittingStep::response;
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
