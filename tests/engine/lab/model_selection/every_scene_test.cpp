// Each scene that we have, ours and others'. Covers engine/lab/model_selection/choose.cpp: what is
// chosen for each of ours is within its tolerance, and the next cheaper is not, some seconds each;
// and that a million steps of the proxy at random cross nothing.
#include "engine/contact/mesh/mesh_preparation.h"
#include "engine/contact/proxy/proxy.h"
#include "engine/lab/model_selection/choose.h"
#include "engine/lab/model_selection/contact_shapes.h"
#include "engine/lab/rig/brute_force_proxy.h"
#include "engine/lab/rig/scenario/test_surfaces.h"
#include "engine/scene/scene.h"
#include "tests/engine/contact/mesh/soups.h"
#include "tests/engine/lab/model_selection/model_settings.h"
#include "tests/support/cases.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
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
class AgainstFullest {
public:
    explicit AgainstFullest(const scene::Scene &scene)
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
    const AgainstFullest measured(scene);
    EXPECT_TRUE(meets(measured.error_of(choice), scene.tolerance));
    std::size_t cheaper_ones = 0;
    for (std::size_t axis = 0; axis < choice.axes.size(); ++axis) {
        for (const CheaperTrial &cheaper : choice.axes[axis].cheaper) {
            const auto &candidates = choice.axes[axis].candidates;
            EXPECT_LT(candidates[cheaper.candidate].cost.min_ns,
                      candidates[choice.axes[axis].chosen].cost.min_ns);
            ModelSelection instead = choice;
            instead.axes[axis].chosen = cheaper.candidate;
            EXPECT_FALSE(meets(measured.error_of(instead), scene.tolerance))
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

namespace springdrive::rig {
namespace {

std::vector<std::string> scene_files() {
    std::vector<std::string> files;
    for (const char *folder : {SPRINGDRIVE_ASSET_DIR "/scenes", SPRINGDRIVE_MODELS_DIR}) {
        if (std::filesystem::is_directory(folder)) {
            for (const auto &entry : std::filesystem::directory_iterator(folder)) {
                const std::string extension = entry.path().extension();
                if (extension == ".gltf" || extension == ".glb") {
                    files.push_back(entry.path());
                }
            }
        }
    }
    std::ranges::sort(files);
    return files;
}

std::string name_of(const ::testing::TestParamInfo<std::string> &info) {
    std::string name = std::filesystem::path(info.param).stem();
    std::ranges::replace_if(
        name, [](char c) { return std::isalnum(c) == 0; }, '_');
    return name;
}

class LongWalk : public ::testing::TestWithParam<std::string> {};

TEST_P(LongWalk, CrossesNothing) {
    const int steps = testing::cases(20'000, 1'000'000);
    const scene::Scene scene = touch_scene(GetParam(), testing::phantom_1_0().workspace);
    const contact::HapticSurface surface = scene::haptic_surface_of(scene);
    const std::vector<PlainTriangle> triangles =
        plain_triangles(contact::prepare_mesh(scene.surface).facets);
    const NearbyTriangles finder(triangles);
    const Vector3 middle_m = 0.5 * (scene.lower_m + scene.upper_m);
    const Vector3 half_m = 0.6 * (scene.upper_m - scene.lower_m) + Vector3::Constant(2e-3);
    std::mt19937_64 random(1);
    Vector3 tip_m = middle_m + half_m;
    Vector3 heading = -half_m.normalized();
    contact::Proxy proxy;
    proxy.reset(tip_m);
    int touching = 0;
    for (int step = 0; step < steps; ++step) {
        // 0.2 m/s at 1 kHz.
        heading = (heading + 0.2 * testing::random_direction(random)).normalized();
        tip_m += 2e-4 * heading;
        for (int axis = 0; axis < 3; ++axis) {
            if (std::abs(tip_m[axis] - middle_m[axis]) > half_m[axis]) {
                heading[axis] = std::copysign(heading[axis], middle_m[axis] - tip_m[axis]);
            }
        }
        const contact::Contact contact = proxy.update(surface, tip_m);
        touching += contact.touching ? 1 : 0;
        const contact::ProxyPath &path = proxy.path();
        for (std::size_t piece = 0; piece + 1 < path.size(); ++piece) {
            ASSERT_FALSE(finder.crossed(path[piece], path[piece + 1])) << "step " << step;
        }
    }
    EXPECT_GT(touching, steps / 10); // not vacuous
}

INSTANTIATE_TEST_SUITE_P(EveryScene, LongWalk, ::testing::ValuesIn(scene_files()), name_of);

} // namespace
} // namespace springdrive::rig
