// The project's own scenes: what is chosen for each is within its tolerance, and the next cheaper
// is not. Some seconds each. Covers engine/lab/model_selection/ as a whole.
#include "engine/lab/model_selection/contact_shapes.h"
#include "engine/lab/model_selection/scene_model.h"
#include "tests/engine/lab/model_selection/model_settings.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

namespace springdrive::model_selection {
namespace {

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
