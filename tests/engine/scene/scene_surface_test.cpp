// Covers engine/scene/scene_surface.cpp.
#include "engine/scene/scene_surface.h"

#include "tests/engine/contact/mesh/soups.h"
#include "tests/support/error_text.h"

#include <gtest/gtest.h>

namespace springdrive::scene {
namespace {

TEST(SceneSurface, NamesTheFileWhoseSurfaceIsTooMuchWork) {
    std::mt19937_64 random(1);
    Scene scene;
    scene.file = "folder/line.glb";
    scene.surface = testing::soup_in_a_line(random, 6000);
    EXPECT_TRUE(testing::error_text_of([&] {
                    static_cast<void>(haptic_surface_of(scene));
                }).starts_with("folder/line.glb: preparing its 6000 triangles for touch needs "));
}

} // namespace
} // namespace springdrive::scene
