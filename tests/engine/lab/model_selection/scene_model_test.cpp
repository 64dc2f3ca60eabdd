// Covers engine/lab/model_selection/scene_model.cpp.
#include "engine/lab/model_selection/scene_model.h"

#include "tests/engine/lab/model_selection/model_settings.h"

#include <gtest/gtest.h>

#include <algorithm>
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

} // namespace
} // namespace springdrive::model_selection
