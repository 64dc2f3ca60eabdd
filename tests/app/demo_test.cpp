// Covers app/main.cpp and app/demo/demo.cpp: the program from outside; and stage/load_lines.cpp.
#include "app/stage/frame_loop.h"
#include "tests/support/csv.h"
#include "tests/support/devices.h"
#include "tests/support/program.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace springdrive::app {
namespace {

bool has_display() {
    return std::getenv("DISPLAY") != nullptr ||       // NOLINT(concurrency-mt-unsafe)
           std::getenv("WAYLAND_DISPLAY") != nullptr; // NOLINT(concurrency-mt-unsafe)
}

std::filesystem::path written(const std::filesystem::path &folder, const std::string &name,
                              const std::string &text) {
    std::ofstream(folder / name, std::ios::binary) << text;
    return folder / name;
}

/// A glTF with one triangle of three given corners.
std::string one_triangle(const std::string &buffer_base64, int indices_count,
                         const std::string &mode) {
    return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],)"
           R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1,"mode":)" +
           mode + R"(}]}],"accessors":[{"bufferView":0,"componentType":5126,"count":3,)" +
           R"("type":"VEC3","min":[0,0,0],"max":[1,1,0]},{"bufferView":1,"componentType":5121,)" +
           R"("count":)" + std::to_string(indices_count) +
           R"(,"type":"SCALAR"}],"bufferViews":[{"buffer":0,"byteLength":36},)"
           R"({"buffer":0,"byteOffset":36,"byteLength":4}],"buffers":[{"byteLength":40,)"
           R"("uri":"data:application/octet-stream;base64,)" +
           buffer_base64 + R"("}]})";
}

// Corners (0,0,0), (1,0,0), (0,1,0) and the indices 0 1 2 0; then the same with the last index 9,
// and with a NaN for the second x.
const std::string kGood = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAECAA==";
const std::string kIndexNine = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAEJAA==";
const std::string kNan = "AAAAAAAAAAAAAAAAAADAfwAAAAAAAAAAAAAAAAAAgD8AAAAAAAECAA==";

TEST(Program, SaysWhatIsWrongWithASceneInOneLine) {
    const std::filesystem::path folder = testing::fresh_folder("bad_scenes");
    const std::string sphere = testing::contents_of(testing::assets() / "scenes/sphere.gltf");
    const std::string glb =
        "glTF" + std::string("\x02\0\0\0\xff\xff\0\0\x10\0\0\0JSON{\"asset\":", 24);
    for (const auto &[name, text] : std::vector<std::pair<std::string, std::string>>{
             {"text.glb", "this is a shopping list\nmilk\n"},
             {"empty.glb", ""},
             {"half.gltf", sphere.substr(0, sphere.size() / 2)},
             {"index.gltf", one_triangle(kIndexNine, 3, "4")},
             {"nan.gltf", one_triangle(kNan, 3, "4")},
             {"points.gltf", one_triangle(kGood, 3, "0")},
             {"truncated.glb", glb}}) {
        testing::expect_refused(
            testing::run_program({"demo", "--scene", written(folder, name, text)}), name);
    }
    const testing::Ending none = testing::run_program({"demo", folder / "none.gltf"});
    testing::expect_refused(none, "none.gltf"); // taken by its kind, as a file manager names it
    EXPECT_EQ(none.error.find("--open"), std::string::npos) << none.error;
}

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

/// A record as CSV.
std::string telemetry_of(const std::filesystem::path &record) {
    const testing::Ending ending = testing::run_program({"export", record, "--csv", "-"});
    EXPECT_EQ(ending.exit_status, 0) << ending.error;
    return ending.out;
}

class Demo : public ::testing::Test {
protected:
    void SetUp() override {
        if (!has_display()) {
            GTEST_SKIP() << "needs a display; tests/run starts a virtual one";
        }
    }
};

TEST_F(Demo, LockstepRunsRepeatToTheLastBit) {
    const std::filesystem::path folder = testing::fresh_folder("lockstep");
    for (const char *name : {"first", "second"}) {
        const testing::Ending ending = testing::run_program(
            {"--lockstep", "--frames", "75", "--screenshot", folder / (std::string(name) + ".png"),
             "--record", folder / (std::string(name) + ".rec"), "--width", "640", "--height",
             "400"});
        ASSERT_EQ(ending.exit_status, 0) << ending.error;
    }
    const std::string telemetry = telemetry_of(folder / "first.rec");
    // 75 frames of 1/60 s are 1250 ticks, and the header.
    EXPECT_EQ(std::count(telemetry.begin(), telemetry.end(), '\n'), 1251);
    EXPECT_TRUE(telemetry == telemetry_of(folder / "second.rec"));
    EXPECT_EQ(testing::contents_of(folder / "first.png").substr(1, 3), "PNG");
    EXPECT_GT(testing::contents_of(folder / "first.png").size(), 20'000U);
    std::filesystem::remove_all(folder);
}

TEST_F(Demo, FollowsAPathFromAFile) {
    const std::filesystem::path folder = testing::fresh_folder("path");
    const std::filesystem::path path =
        written(folder, "path.csv", "t,x,y,z\n0,0,0.08,0\n1.2,0,0.08,0\n1.7,0.03,0.08,0\n");
    const testing::Ending ending = testing::run_program(
        {"demo", "--lockstep", "--seconds", "2.4", "--without", "all", "--path", path, "--scene",
         testing::assets() / "scenes/plate.gltf", "--record", folder / "t.rec"});
    ASSERT_EQ(ending.exit_status, 0) << ending.error;
    const std::string telemetry = telemetry_of(folder / "t.rec");
    const std::vector<std::string> names = testing::parsed_csv(telemetry).front();
    const std::vector<double> last = testing::parsed_numbers(telemetry).back();
    const auto value = [&](const char *name) {
        return last.at(static_cast<std::size_t>(std::ranges::find(names, name) - names.begin()));
    };
    // At rest with its target, to an encoder count.
    EXPECT_NEAR(value("tip_x_m"), 0.03, 5e-5);
    EXPECT_NEAR(value("tip_y_m"), 0.08, 5e-5);
    std::filesystem::remove_all(folder);
}

TEST_F(Demo, ASignalEndsItProperly) {
    const std::filesystem::path folder = testing::fresh_folder("signal");
    for (const int signal : {SIGTERM, SIGINT}) {
        const std::filesystem::path telemetry = folder / (std::to_string(signal) + ".rec");
        const testing::Ending ending = testing::run_program(
            {"--width", "640", "--height", "400", "--record", telemetry}, signal, telemetry);
        EXPECT_EQ(ending.exit_status, 0) << ending.error;
        RecordProperty("seconds_after_signal", std::to_string(ending.after_signal.count()));
    }
}

} // namespace
} // namespace springdrive::app
