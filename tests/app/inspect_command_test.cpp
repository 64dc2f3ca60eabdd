// Covers app/commands/inspect_command.cpp, from outside.
#include "tests/support/files.h"
#include "tests/support/program.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace springdrive::app {
namespace {

using nlohmann::json;

const std::string kScenes = SPRINGDRIVE_ASSET_DIR "/scenes/";

/// Without the model, which takes seconds to measure.
testing::Ending inspect(std::vector<std::string> options) {
    options.insert(options.begin(), "inspect");
    options.emplace_back("--no-model");
    return testing::run_program(options);
}

json inspected(const std::string &scene) {
    const testing::Ending ending = inspect({scene, "--json", "-"});
    EXPECT_EQ(ending.exit_status, 0) << ending.error;
    EXPECT_EQ(ending.error, "");
    return json::parse(ending.out);
}

TEST(InspectCommand, TellsWhatTheNodesAreMadeOf) {
    const json said = inspected(kScenes + "compliance.gltf");
    EXPECT_EQ(said["file_bytes"], std::filesystem::file_size(kScenes + "compliance.gltf"));
    EXPECT_TRUE(said["in_metres"]);
    const std::vector<std::pair<std::string, double>> expected{
        {"rigid", 0.0}, {"firm", 0.25}, {"medium", 0.5}, {"soft", 0.75}, {"softest", 0.9}};
    ASSERT_EQ(said["nodes"].size(), expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) {
        EXPECT_EQ(said["nodes"][i]["name"], expected[i].first);
        EXPECT_EQ(said["nodes"][i]["eta"], expected[i].second);
        EXPECT_EQ(said["nodes"][i]["triangles"], 12);
        EXPECT_EQ(said["nodes"][i]["one_sided_triangles"], 12);
        EXPECT_EQ(said["nodes"][i]["two_sided_triangles"], 0);
    }
    EXPECT_NEAR(said["lower_m"][0], -0.061, 1e-8); // single precision in the file
    EXPECT_NEAR(said["upper_m"][2], 0.015, 1e-8);
}

TEST(InspectCommand, TellsWhatThereIsToFeelAndWhere) {
    const json lesson = inspected(kScenes + "wrong_direction.gltf")["lesson"];
    EXPECT_EQ(lesson["title"], "The wrong direction");
    EXPECT_NEAR(lesson["point_m"][2], 0.0358, 1e-12);
    EXPECT_GT(lesson["normal"][1], 0.9);
    const testing::Ending text = inspect({kScenes + "wrong_direction.gltf"});
    for (const std::string said :
         {"title     The wrong direction", "feel      Press on the orange"}) {
        EXPECT_NE(text.out.find(said), std::string::npos) << text.out;
    }
    EXPECT_FALSE(inspected("sphere:1280").contains("lesson"));
}

TEST(InspectCommand, TellsWhatPreparationFound) {
    const json said = inspected(kScenes + "stepped_block.gltf");
    EXPECT_EQ(said["mesh"]["triangles_given"], said["mesh"]["triangles_kept"]);
    EXPECT_EQ(said["mesh"]["components"], 1);
    EXPECT_EQ(said["mesh"]["closed_components"], 1);
    EXPECT_EQ(said["mesh"]["open_edges"], 0);
    EXPECT_GT(said["mesh"]["welded_vertices"], 0); // flat faces, each with its own corners
    EXPECT_GT(said["bytes"], 0);
    EXPECT_GE(said["preparation_s"], 0.0);
    EXPECT_TRUE(said["remarks"].empty());
}

TEST(InspectCommand, SaysHowASceneWasFitted) {
    const json said = inspected(kScenes + "organic.gltf");
    EXPECT_FALSE(said["in_metres"]);
    EXPECT_GT(said["metres_per_unit"], 0.0);
    EXPECT_LT(said["metres_per_unit"], 1.0);
    const testing::Ending text = inspect({kScenes + "organic.gltf"});
    EXPECT_NE(text.out.find("fitted to the workspace"), std::string::npos) << text.out;
}

TEST(InspectCommand, PrintsATableWithMeanings) {
    const testing::Ending ending = inspect({"sphere:1280"});
    ASSERT_EQ(ending.exit_status, 0) << ending.error;
    EXPECT_EQ(ending.error, "");
    for (const char *said : {"metres of the device's frame", "100.00 mm", "triangles kept",
                             "can be touched", "closed surfaces", "bytes per triangle"}) {
        EXPECT_NE(ending.out.find(said), std::string::npos) << said << " in\n" << ending.out;
    }
    EXPECT_EQ(ending.out.find("remark"), std::string::npos) << ending.out;
}

TEST(InspectCommand, TellsWhichModelTheSceneWouldGetAndRemembersIt) {
    const std::filesystem::path cache = testing::fresh_folder("inspect_cache");
    setenv("XDG_CACHE_HOME", cache.c_str(), 1);
    const std::vector<std::string> options{"inspect", kScenes + "profile.gltf", "--json", "-"};
    const testing::Ending first = testing::run_program(options);
    ASSERT_EQ(first.exit_status, 0) << first.error;
    EXPECT_EQ(first.error, ""); // progress is for terminals
    const json model = json::parse(first.out)["model"];
    ASSERT_EQ(model["axes"].size(), 5U);
    for (const json &axis : model["axes"]) {
        EXPECT_EQ(axis["candidates"].back()["verdict"], "meets"); // the full model
    }
    EXPECT_EQ(model["axes"][2]["name"], "joints");
    EXPECT_EQ(model["axes"][2]["chosen"], "2");

    const testing::Ending again =
        testing::run_program(options); // times would differ if it were measured again
    EXPECT_EQ(json::parse(again.out)["model"], model);
    const testing::Ending text = testing::run_program({"inspect", kScenes + "profile.gltf"});
    for (const char *said : {"model: force to 0.1 N", "<- selected", "transpose_on_the_fly",
                             "relative to the full model", "per tick instead of"}) {
        EXPECT_NE(text.out.find(said), std::string::npos) << said << " in\n" << text.out;
    }
    auto measured_anew = options;
    measured_anew.emplace_back("--fresh");
    EXPECT_NE(json::parse(testing::run_program(measured_anew).out)["model"], model);
    unsetenv("XDG_CACHE_HOME");
}

TEST(InspectCommand, ASceneOfNothingButThinTrianglesIsRefused) {
    const std::filesystem::path file = testing::fresh_folder("inspect_thin") / "thin.gltf";
    std::ofstream(file) << R"({"asset":{"version":"2.0"},"nodes":[{"mesh":0}],"meshes":[{)"
                        << R"("primitives":[{"attributes":{"POSITION":0}}]}],"accessors":[{)"
                        << R"("bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],)"
                        << R"("bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{)"
                        << R"("byteLength":36,"uri":"data:;base64,)" // three points in a line
                        << R"(AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAQAAAAAAAAAAA"}]})";
    const testing::Ending ending = inspect({file.string()});
    EXPECT_GT(ending.exit_status, 0);
    EXPECT_EQ(ending.error, "springdrive: " + file.string() +
                                ": has nothing to touch: its triangles, 1 in number, are all too "
                                "thin to have a normal; export it again\n");
}

TEST(InspectCommand, SaysWhatIsWrongInOneLine) {
    const auto expect_refused = [](const std::vector<std::string> &options,
                                   const std::string &names) {
        const testing::Ending ending = inspect(options);
        EXPECT_GT(ending.exit_status, 0) << names;
        EXPECT_EQ(std::count(ending.error.begin(), ending.error.end(), '\n'), 1) << ending.error;
        EXPECT_NE(ending.error.find(names), std::string::npos) << ending.error;
        EXPECT_EQ(ending.out, "");
    };
    expect_refused({}, "scene");
    expect_refused({"none.glb"}, "none.glb");
    expect_refused({kScenes}, kScenes);
    expect_refused({"bumpy:7"}, "1310720");
    expect_refused({"sphere:1280", "--device-file", "none.toml"}, "none.toml");
    expect_refused({"sphere:1280", "--json", "/dev/full"}, "/dev/full");
}

} // namespace
} // namespace springdrive::app
