// Covers engine/scene/load_progress.cpp, warning_list.cpp and scene_surface.cpp: what is said about
// loading; and how much memory gltf.cpp lets it take.
#include "engine/scene/load_progress.h"
#include "engine/scene/scene_surface.h"
#include "engine/scene/warning_list.h"
#include "tests/engine/contact/mesh/soups.h"
#include "tests/engine/scene/gltf_builder.h"
#include "tests/support/error_text.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <random>
#include <string>
#include <vector>

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

/// A triangle takes 300 bytes and a vertex 220: of 8 GiB, 39,045,155.9 vertices beside one
/// triangle.
TEST(WorkBudget, EndsAtTheStatedMemory) {
    const auto declaring = [](int vertices) {
        GltfBuilder builder = one_triangle();
        builder.add_accessor(std::vector<std::uint8_t>{0, 1, 2}, kUnsignedByte, "SCALAR");
        builder.meshes = {R"({"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]})"};
        builder.accessors[0] = R"({"bufferView": 0, "componentType": 5126, "count": )" +
                               std::to_string(vertices) + R"(, "type": "VEC3"})";
        return builder;
    };
    expect_failure(
        declaring(39'045'156),
        "node 0: with it the scene has 1 triangles and 39045156 vertices, "
        "for which loading needs about 8 GiB of memory; at most 8 GiB are allowed: simplify it");
    // Just few enough to look inside.
    expect_failure(declaring(39'045'155), "its 39045155 elements reach beyond buffer view 0");
}

using Lines = std::vector<std::string>;

TEST(WarningList, EqualWarningsOnSeveralThingsAreOneLine) {
    WarningList warnings;
    warnings.add_of("node 'a'", nullptr, "is left out");
    warnings.add("the scene stands still");
    EXPECT_EQ(warnings.lines(), (Lines{"node 'a': is left out", "the scene stands still"}));
    warnings.add_of("node 7", nullptr, "is left out");
    warnings.add_of("image 'a'", nullptr, "is left out");
    EXPECT_EQ(warnings.lines(), (Lines{"nodes 'a', 7: is left out", "the scene stands still",
                                       "image 'a': is left out"}));
    warnings.add_of("node 'b c'", nullptr, "is left out");
    warnings.add_of("node 'd'", nullptr, "is left out");
    warnings.add_of("node 'e'", nullptr, "is left out");
    EXPECT_EQ(warnings.lines().front(), "nodes 'a', 7, 'b c' and 2 more: is left out");
}

TEST(WarningList, NumbersAreAddedUp) {
    WarningList warnings;
    warnings.add_of("node 'a'", nullptr, 3, "points are left out");
    EXPECT_EQ(warnings.lines(), Lines{"node 'a': 3 points are left out"});
    warnings.add_of("node 'b'", nullptr, 4, "points are left out");
    EXPECT_EQ(warnings.lines(), Lines{"nodes 'a', 'b': 7 points are left out"});
}

TEST(WarningList, PartsOfOneThingCountOnce) {
    WarningList warnings;
    const int a = 0;
    const int b = 0;
    for (const int *identity : {&a, &a, &b, &b}) {
        warnings.add_of("node 'same'", identity, 1, "points are left out");
    }
    EXPECT_EQ(warnings.lines(), Lines{"nodes 'same', 'same': 4 points are left out"});
}

TEST(WarningList, TheNumberOfLinesIsBounded) {
    WarningList warnings;
    for (std::size_t i = 0; i < kMaxWarningLines; ++i) {
        warnings.add(std::to_string(i));
    }
    EXPECT_EQ(warnings.lines().size(), kMaxWarningLines);
    EXPECT_EQ(warnings.lines().back(), std::to_string(kMaxWarningLines - 1));
    warnings.add("one");
    warnings.add("two");
    EXPECT_EQ(warnings.lines().size(), kMaxWarningLines);
    EXPECT_EQ(warnings.lines().back(), "and 3 more remarks");
}

TEST(SceneSurface, NamesTheFileWhoseSurfaceIsTooMuchWork) {
    std::mt19937_64 random(1);
    Scene scene;
    scene.file = "folder/line.glb";
    scene.surface = testing::soup_in_a_line(random, 6000);
    const std::string error =
        testing::error_text_of([&] { static_cast<void>(haptic_surface_of(scene)); });
    EXPECT_TRUE(error.starts_with("folder/line.glb: preparing its 6000 triangles for touch needs "
                                  "about "))
        << error;
    EXPECT_NE(error.find("; at most 2012 million are allowed: "), std::string::npos) << error;
}

} // namespace
} // namespace springdrive::scene
