// Covers engine/scene/load_progress.cpp and load_allowance.cpp.
#include "engine/scene/load_progress.h"

#include "engine/scene/load_allowance.h"
#include "tests/engine/scene/gltf_builder.h"

namespace springdrive::scene {
namespace {

TEST(LoadProgress, TellsStageAndPercentWhereItIsKnown) {
    LoadProgress progress;
    EXPECT_EQ(progress.text(), "reading the file");
    progress.begin(LoadProgress::Stage::gathering, true);
    EXPECT_EQ(progress.text(), "gathering triangles, 0 %");
    progress.advance_to(0.404);
    EXPECT_EQ(progress.text(), "gathering triangles, 40 %");
    progress.advance_to(1.1);
    EXPECT_EQ(progress.text(), "gathering triangles, 100 %");
    progress.begin(LoadProgress::Stage::preparing, false);
    EXPECT_EQ(progress.text(), "preparing the surface for touch");
    progress.begin(LoadProgress::Stage::measuring, true);
    progress.advance_to(0.1);
    EXPECT_EQ(progress.text(), "measuring models, 10 %");
}

TEST(LoadProgress, LoadingEndsWithEverythingPlaced) {
    const TemporaryFolder folder;
    LoadProgress progress;
    const Scene scene =
        load_gltf(folder.write("scene.gltf", one_triangle().gltf()), small_workspace(), &progress);
    EXPECT_EQ(progress.stage(), LoadProgress::Stage::placing);
    EXPECT_EQ(progress.text(), "placing the scene, 100 %");
    EXPECT_EQ(scene.surface.triangles.size(), 1U);
}

TEST(WorkBudget, EndsAtTheStatedMemory) {
    // 300 bytes a triangle and 220 a vertex are 8 GiB at 16,519,104.98 of each.
    gltf::WorkBudget allowance;
    EXPECT_NO_THROW(allowance.add(16'000'000, 16'000'000));
    EXPECT_NO_THROW(allowance.add(519'104, 519'104));
    EXPECT_THROW(allowance.add(1, 1), InputError);
    EXPECT_THROW(gltf::WorkBudget().add(0, 60'000'000), InputError);
    EXPECT_NO_THROW(gltf::WorkBudget().add(10'000'000, 20'000'000));
}

} // namespace
} // namespace springdrive::scene
