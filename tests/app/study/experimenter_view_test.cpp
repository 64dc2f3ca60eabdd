// Covers app/study/experimenter/experimenter_view.cpp: what a blind experimenter sees of a session.
#include "app/study/experimenter/experimenter_view.h"

#include "engine/study/conduct/conduct.h"
#include "tests/app/study/sitting_rig.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <vector>

namespace springdrive::app::study_screen {
namespace {

/// Where things are drawn, and the force.
std::vector<Vector3> drawn_of(const ViewState &state) {
    const device::LinkagePose &linkage = state.linkage;
    return {state.tip_m,     state.proxy_m, state.tip_force_N, state.hand_target_m,
            linkage.elbow_m, linkage.tip_m, state.normal,      state.below->point_m};
}

/// How far apart two of them are, at the most.
double spread_of(const std::vector<std::vector<Vector3>> &all) {
    double most = 0.0;
    for (const std::vector<Vector3> &one : all) {
        for (std::size_t i = 0; i < one.size(); ++i) {
            most = std::max(most, (one[i] - all.front()[i]).norm());
        }
    }
    return most;
}

/// Through all presentations of a study whose forces turn by 20 and 60 degrees to either side, and
/// push the hand there.
TEST_F(StudySitting, ABlindExperimenterSeesTheSameOfEveryStimulus) {
    std::vector<std::vector<Vector3>> blind;
    std::vector<std::vector<Vector3>> seeing;
    double blind_force_N = 0.0;
    const study::SessionEnding ending = run([&](MadeUpPort &port, session::Session &session) {
        const study::StudySetting setting = study::study_setting(protocol_, folders_);
        port.on_frame = [&, setting](const ParticipantPicture &, const SittingState &state) {
            const servo::ServoSample &now = session.latest();
            const auto view = [&](const std::optional<Vector3> &hidden_at) {
                return experimenter_view(now, session.description(), session.scenes().now().surface,
                                         hidden_at);
            };
            const Vector3 at_m =
                state.trial
                    ? setting.conditions[study::condition_of(protocol_, *state.trial)].spot.point_m
                    : now.tip_m;
            blind_force_N = std::max(blind_force_N, view(at_m).tip_force_N.norm());
            if (now.contact.touching && state.step == SittingStep::interval) {
                blind.push_back(drawn_of(view(at_m)));
                seeing.push_back(drawn_of(view(std::nullopt)));
            }
        };
    });
    EXPECT_EQ(ending, study::SessionEnding::completed);
    ASSERT_GT(blind.size(), 100U);
    EXPECT_EQ(spread_of(blind), 0.0);
    EXPECT_EQ(blind_force_N, 0.0);
    EXPECT_GT(spread_of(seeing), 0.1) << "of forces, in N: there is something to hide";
}

} // namespace
} // namespace springdrive::app::study_screen
