#include "app/stage/open_session.h"

#include <gtest/gtest.h>

#include <chrono>
#include <sstream>
#include <thread>

namespace springdrive::app {
namespace {

TEST(LoadLines, AFastLoadGoesWithoutAWordAndEndsAtOnce) {
    const auto start = std::chrono::steady_clock::now();
    const scene::LoadProgress progress;
    std::ostringstream out;
    { const LoadLines lines("scene.glb", progress, out, std::chrono::hours(1)); }
    EXPECT_EQ(out.str(), "");
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::minutes(1));
}

TEST(LoadLines, ASlowOneTellsFileStageAndPercent) {
    scene::LoadProgress progress;
    progress.begin(scene::LoadProgress::Stage::gathering, true);
    progress.advance_to(0.5);
    std::ostringstream out;
    {
        const LoadLines lines("scene.glb", progress, out, std::chrono::milliseconds(5));
        std::this_thread::sleep_for(std::chrono::milliseconds(200));
    }
    const std::string line = "springdrive: scene.glb: gathering triangles, 50 %\n";
    EXPECT_TRUE(out.str().starts_with(line + line)) << out.str();
}

} // namespace
} // namespace springdrive::app
