// Covers engine/lab/model_selection/choose.cpp on scenes. For the project's own scenes: what is
// chosen for each is within its tolerance, and the next cheaper is not. Some seconds each.
#include "engine/lab/model_selection/choose.h"

#include "engine/lab/model_selection/contact_shapes.h"
#include "tests/engine/lab/model_selection/model_settings.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace springdrive::model_selection {
namespace {

ModelSelection chosen_for(const scene::Scene &scene) {
    return choose_scene_model({&scene, testing::phantom_1_0(), {}, 1e-3, 0});
}

TEST(SceneModel, ReportsCostAndErrorOfEachCandidate) {
    const scene::Scene scene = testing::own_scene("profile");
    std::vector<double> shares;
    const ModelSelection choice =
        choose_scene_model({&scene, testing::phantom_1_0(), {}, 1e-3, 0},
                           [&](const std::string &, double share) { shares.push_back(share); });
    ASSERT_EQ(choice.axes.size(), kModelAspects);
    for (const ModelAxis &axis : choice.axes) {
        for (const Candidate &candidate : axis.candidates) {
            EXPECT_GT(candidate.cost.min_ns, 0.0) << axis.name << ' ' << candidate.name;
            EXPECT_GE(candidate.error.force_N, 0.0) << axis.name << ' ' << candidate.name;
        }
        EXPECT_EQ(axis.candidates.back().error.force_N, 0.0) << axis.name;
    }
    EXPECT_EQ(choice.axis(ModelAspect::joints).candidates.size(), 2U);
    EXPECT_EQ(choice.axis(ModelAspect::steps).candidates.size(), 6U); // 1 ms to 31 µs
    EXPECT_TRUE(std::ranges::is_sorted(shares));
    EXPECT_LE(shares.back(), 1.0);
    EXPECT_EQ(model_of(choice).planar, choice.chosen(ModelAspect::joints) == "2");
}

TEST(SceneModel, WithZeroToleranceEveryAxisHasZeroError) {
    scene::Scene scene = testing::own_scene("plate");
    scene.tolerance = {1e-4, 1e-4, 200.0};
    const ModelSelection choice = chosen_for(scene);
    EXPECT_LE(choice.error.force_N, 1e-4);
    EXPECT_EQ(choice.chosen(ModelAspect::plant), "full");
    EXPECT_EQ(choice.chosen(ModelAspect::steps), "32");
    EXPECT_EQ(choice.chosen(ModelAspect::controller), "transpose_on_the_fly");
}

TEST(SceneModel, ASurfaceThatPushesSidewaysKeepsThreeJointsWithAWarning) {
    scene::Scene scene = testing::own_scene("profile");
    ASSERT_TRUE(scene.planar);
    for (Vector3 &vertex_m : scene.surface.vertices_m) { // leaning by 27° to the side
        vertex_m.y() += 0.5 * vertex_m.x();
    }
    scene.lower_m.y() -= 0.015;
    scene.upper_m.y() += 0.015;
    scene.tolerance = {0.1, 0.1, 100.0};
    const ModelSelection choice = chosen_for(scene);
    EXPECT_EQ(choice.chosen(ModelAspect::joints), "3");
    ASSERT_EQ(choice.warnings.size(), 1U);
    EXPECT_NE(choice.warnings[0].find("pushes sideways"), std::string::npos);
}

TEST(SceneModel, ReportsWhereNothingWasTouched) {
    scene::Scene scene = testing::own_scene("plate");
    for (Vector3 &vertex_m : scene.surface.vertices_m) {
        vertex_m.y() += 2.0;
    }
    scene.lower_m.y() += 2.0;
    scene.upper_m.y() += 2.0;
    const ModelSelection choice = chosen_for(scene);
    ASSERT_EQ(choice.warnings.size(), 1U);
    EXPECT_NE(choice.warnings[0].find("did not touch"), std::string::npos);
}

const std::vector<std::string> kOwnScenes = {
    "plate",   "slope",      "wrong_direction", "compliance", "stepped_block", "profile",
    "organic", "thin_plate", "sphere",          "spheres",    "blow"};

/// The error of a model of the scene against the fullest, measured again.
class Trial {
public:
    explicit Trial(const scene::Scene &scene)
        : scene_(scene), given_(haptic_surface_of(scene, {})) {
        rig::Exploration how;
        how.planar = scene.planar;
        setting_.emplace(testing::exploring(given_, testing::box_of(scene), how));
        Model fullest;
        fullest.steps = 32;
        fullest_ = run_model(*setting_, fullest, given_);
    }

    [[nodiscard]] ModelError error_of(const ModelSelection &choice) const {
        const Model model = model_of(choice);
        const ModelRun run = run_model(*setting_, model, haptic_surface_of(scene_, model.shape));
        return model_error(run, fullest_, setting_->scenario.simulation.servo_period_s,
                           scene_.tolerance.bandwidth_hz);
    }

private:
    const scene::Scene &scene_;
    contact::HapticSurface given_;
    std::optional<ModelSetting> setting_;
    ModelRun fullest_;
};

class OwnScenesModel : public ::testing::TestWithParam<std::string> {};

TEST_P(OwnScenesModel, IsWithinTheToleranceAndTheNextCheaperIsNot) {
    const scene::Scene scene = testing::own_scene(GetParam());
    const ModelSelection choice = choose_scene_model({&scene, testing::phantom_1_0(), {}, 1e-3, 0});
    const Trial trial(scene);
    EXPECT_TRUE(meets(trial.error_of(choice), scene.tolerance));
    std::size_t cheaper_ones = 0;
    for (std::size_t axis = 0; axis < choice.axes.size(); ++axis) {
        for (const CheaperTrial &cheaper : choice.axes[axis].cheaper) {
            const auto &candidates = choice.axes[axis].candidates;
            EXPECT_LT(candidates[cheaper.candidate].cost.min_ns,
                      candidates[choice.axes[axis].chosen].cost.min_ns);
            ModelSelection instead = choice;
            instead.axes[axis].chosen = cheaper.candidate;
            EXPECT_FALSE(meets(trial.error_of(instead), scene.tolerance))
                << choice.axes[axis].name << ' ' << candidates[cheaper.candidate].name;
            ++cheaper_ones;
        }
    }
    EXPECT_GT(cheaper_ones, 0U);
    EXPECT_LT(choice.cost_ns, choice.fullest_cost_ns);
}

INSTANTIATE_TEST_SUITE_P(All, OwnScenesModel, ::testing::ValuesIn(kOwnScenes),
                         [](const auto &scene) { return scene.param; });

TEST(OwnScenesModels, AreAllOfThem) {
    std::set<std::string> files;
    for (const auto &entry : std::filesystem::directory_iterator(testing::assets() / "scenes")) {
        if (entry.path().extension() == ".gltf") {
            files.insert(entry.path().stem());
        }
    }
    EXPECT_EQ(files, std::set<std::string>(kOwnScenes.begin(), kOwnScenes.end()));
}

} // namespace
} // namespace springdrive::model_selection
