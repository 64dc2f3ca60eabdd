// Covers app/commands/{inspect,touch}_command.cpp, from outside.
#include "tests/support/csv.h"
#include "tests/support/files.h"
#include "tests/support/program.h"
#include "tests/support/variable.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

namespace springdrive::app {
namespace {

using nlohmann::json;

const std::string kScenes = SPRINGDRIVE_ASSET_DIR "/scenes/";
const std::string kSphere = "sphere:1280";

testing::Ending run_on_scene(const char *command, std::vector<std::string> options) {
    options.insert(options.begin(), command);
    return testing::run_program(options);
}

/// Without the model, which takes seconds to measure.
testing::Ending inspect(const std::string &scene) {
    return run_on_scene("inspect", {scene, "--no-model"});
}

json said_by(const char *command, std::vector<std::string> options) {
    options.insert(options.end(), {"--json", "-"});
    const testing::Ending ending = run_on_scene(command, options);
    EXPECT_EQ(ending.exit_status, 0) << ending.error;
    EXPECT_EQ(ending.error, "");
    return json::parse(ending.out);
}
json inspected(const std::string &scene) { return said_by("inspect", {scene, "--no-model"}); }
json touched(std::vector<std::string> options) { return said_by("touch", std::move(options)); }

void expect_says(const std::string &text, const std::vector<const char *> &parts) {
    for (const char *part : parts) {
        EXPECT_NE(text.find(part), std::string::npos) << part << " in\n" << text;
    }
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

TEST(InspectCommand, TellsLessonPreparationAndFit) {
    const json lesson = inspected(kScenes + "wrong_direction.gltf")["lesson"];
    EXPECT_EQ(lesson["title"], "The wrong direction");
    EXPECT_NEAR(lesson["point_m"][2], 0.0358, 1e-12);
    EXPECT_GT(lesson["normal"][1], 0.9);
    expect_says(inspect(kScenes + "wrong_direction.gltf").out,
                {"title     The wrong direction", "feel      Press on the orange"});
    EXPECT_FALSE(inspected(kSphere).contains("lesson"));

    const json block = inspected(kScenes + "stepped_block.gltf");
    EXPECT_EQ(block["mesh"]["triangles_given"], block["mesh"]["triangles_kept"]);
    EXPECT_EQ(block["mesh"]["components"], 1);
    EXPECT_EQ(block["mesh"]["closed_components"], 1);
    EXPECT_EQ(block["mesh"]["open_edges"], 0);
    EXPECT_GT(block["mesh"]["welded_vertices"], 0); // flat faces, each with its own corners
    EXPECT_GT(block["bytes"], 0);
    EXPECT_GE(block["preparation_s"], 0.0);
    EXPECT_TRUE(block["remarks"].empty());

    const json fitted = inspected(kScenes + "organic.gltf");
    EXPECT_FALSE(fitted["in_metres"]);
    EXPECT_GT(fitted["metres_per_unit"], 0.0);
    EXPECT_LT(fitted["metres_per_unit"], 1.0);

    const testing::Ending table = inspect(kSphere);
    EXPECT_EQ(table.error, "");
    expect_says(table.out, {"metres of the device's frame", "100.00 mm", "triangles kept",
                            "can be touched", "closed surfaces", "bytes per triangle"});
    EXPECT_EQ(table.out.find("remark"), std::string::npos) << table.out;
}

TEST(InspectCommand, TellsWhichModelTheSceneWouldGetAndRemembersIt) {
    const testing::Variable cache("XDG_CACHE_HOME", testing::fresh_folder("inspect_cache"));
    const std::string scene = kScenes + "profile.gltf";
    const json model = said_by("inspect", {scene})["model"]; // progress is for terminals
    ASSERT_EQ(model["axes"].size(), 5U);
    for (const json &axis : model["axes"]) {
        EXPECT_EQ(axis["candidates"].back()["verdict"], "meets"); // the full model
    }
    EXPECT_EQ(model["axes"][2]["name"], "joints");
    EXPECT_EQ(model["axes"][2]["chosen"], "2");
    // Times would differ if it were measured again.
    EXPECT_EQ(said_by("inspect", {scene})["model"], model);
    expect_says(run_on_scene("inspect", {scene}).out,
                {"model: force to 0.1 N", "<- selected", "transpose_on_the_fly",
                 "relative to the full model", "per tick instead of"});
    EXPECT_NE(said_by("inspect", {scene, "--fresh"})["model"], model);
}

TEST(InspectCommand, ASceneOfNothingButThinTrianglesIsRefused) {
    const std::filesystem::path file = testing::fresh_folder("inspect_thin") / "thin.gltf";
    std::ofstream(file) << R"({"asset":{"version":"2.0"},"nodes":[{"mesh":0}],"meshes":[{)"
                        << R"("primitives":[{"attributes":{"POSITION":0}}]}],"accessors":[{)"
                        << R"("bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],)"
                        << R"("bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{)"
                        << R"("byteLength":36,"uri":"data:;base64,)" // three points in a line
                        << R"(AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAQAAAAAAAAAAA"}]})";
    testing::expect_refused(inspect(file), file.string() + ": has nothing to touch");
}

TEST(TouchCommand, TellsFiguresOfEveryPath) {
    for (const char *path : {"press", "slide", "lissajous", "rain", "random"}) {
        const json said = touched({kSphere, "--path", path, "--steps", "4000", "--check", "20"});
        EXPECT_EQ(said["path"], path);
        EXPECT_EQ(said["triangles_given"], 1280);
        EXPECT_EQ(said["triangles_kept"], 1280);
        EXPECT_EQ(said["shapes"], 0);
        EXPECT_EQ(said["steps"], 4000);
        EXPECT_GT(said["steps_in_contact"], 50) << path;
        EXPECT_GT(said["bytes"], 100 * 1280) << path;
        for (const char *times : {"contact_ns", "contact_floor_ns", "free_ns", "free_floor_ns"}) {
            ASSERT_TRUE(said[times].is_object()) << path << ' ' << times;
            EXPECT_GT(said[times]["median"], 0.0);
            EXPECT_GE(said[times]["p99"], said[times]["median"]);
            EXPECT_GE(said[times]["p99.9"], said[times]["p99"]);
            EXPECT_GE(said[times]["max"], said[times]["p99.9"]);
        }
        EXPECT_LE(said["contact_floor_ns"]["median"], said["contact_ns"]["median"]);
        EXPECT_EQ(said["pop_throughs"], 0) << path;
        EXPECT_EQ(said["stuck_steps"], 0) << path;
        EXPECT_GE(said["steps_checked"], 20) << path;
        EXPECT_LT(said["largest_lag_m"], 1e-6) << path;
        EXPECT_GT(said["largest_sphere_direction_error_deg"], 0.1) << path; // caused by its facets
    }
    const json file =
        touched({kScenes + "stepped_block.gltf", "--path", "press", "--steps", "3000"});
    EXPECT_GT(file["steps_in_contact"], 100);
    EXPECT_FALSE(file.contains("largest_sphere_direction_error_deg"));
}

TEST(TouchCommand, WritesEveryStepAsCsv) {
    const std::filesystem::path folder = testing::fresh_folder("touch_files");
    const testing::Ending ending =
        run_on_scene("touch", {kSphere, "--steps", "300", "--csv", folder / "steps.csv", "--json",
                               folder / "figures.json", "--strict"});
    ASSERT_EQ(ending.exit_status, 0) << ending.error;
    EXPECT_EQ(ending.out, "");
    EXPECT_EQ(json::parse(testing::contents_of(folder / "figures.json"))["steps"], 300);
    const std::string csv = testing::contents_of(folder / "steps.csv");
    EXPECT_EQ(csv.substr(0, csv.find('\n')), "t,x,y,z,px,py,pz,nx,ny,nz,constraints,ns,lag,still");
    int rows = 0;
    int touching = 0;
    for (const std::vector<double> &row : testing::parsed_numbers(csv)) {
        ASSERT_EQ(row.size(), 14U);
        EXPECT_EQ(row[12] >= 0.0, row[10] > 0.0); // each in contact is checked; else NaN
        EXPECT_FALSE(row[12] >= 1e-6);
        EXPECT_LE(row[13], row[0] + 1e-9);
        EXPECT_NEAR(row[0], 1e-3 * rows, 1e-9);
        const double normal = row[7] * row[7] + row[8] * row[8] + row[9] * row[9];
        EXPECT_NEAR(normal, row[10] > 0.0 ? 1.0 : 0.0, 1e-12);
        touching += row[10] > 0.0 ? 1 : 0;
        ++rows;
    }
    EXPECT_EQ(rows, 300);
    EXPECT_GT(touching, 200);
}

TEST(TouchCommand, SaysWhatItCouldHaveMissed) {
    const json few = touched({kSphere, "--steps", "3000", "--check", "100"});
    EXPECT_EQ(few["steps_sampled"], 100);
    EXPECT_GT(few["steps_to_sample"], 1000);
    EXPECT_NEAR(few["rate_not_excluded"].get<double>(), 0.0295, 1e-4); // 1 − 0.05^(1/100)
    EXPECT_EQ(few["confidence"], 0.95);
    const json all = touched({kSphere, "--steps", "3000", "--check", "all"});
    EXPECT_EQ(all["steps_sampled"], all["steps_to_sample"]);
    EXPECT_EQ(all["steps_sampled"], all["steps_in_contact"]);
    EXPECT_EQ(all["steps_sampled_lagging"], 0);
    expect_says(run_on_scene("touch", {kSphere, "--steps", "3000", "--check", "100"}).out,
                {"a rate below 1 in 33 could have been missed (95 %)"});
    expect_says(run_on_scene("touch", {kSphere, "--steps", "500", "--seed", "7"}).out,
                {"1280 of 1280", "slide", "seed 7", "in contact", "pop-throughs", "stuck",
                 "largest lag", "error from sphere", "all that were in contact",
                 "longest standstill"});
}

TEST(TouchCommand, FollowsAPathFromAFile) {
    const std::string path = testing::fresh_folder("touch_path") / "hand.csv";
    std::ofstream(path) << "0,0,0.06,0\n0.1,0,0.048,0\n0.2,0,0.06,0\n";
    const json said = touched({kSphere, "--path", path});
    EXPECT_EQ(said["steps"], 201); // both ends of 0.2 s at 1 kHz
    EXPECT_GT(said["steps_in_contact"], 20);
    EXPECT_FALSE(said.contains("seed"));
    EXPECT_EQ(touched({kSphere, "--path", path, "--servo-hz", "500"})["steps"], 101);
    EXPECT_EQ(touched({kSphere, "--path", path, "--steps", "40"})["steps"], 40);
}

TEST(TouchCommand, RepeatsARunToTheLastBit) {
    const auto motion = [](const std::string &seed) {
        json said = touched({kSphere, "--path", "random", "--steps", "3000", "--seed", seed});
        for (const char *of_the_clock :
             {"preparation_s", "contact_ns", "contact_floor_ns", "free_ns", "free_floor_ns"}) {
            said.erase(of_the_clock);
        }
        return said;
    };
    EXPECT_EQ(motion("3"), motion("3"));
    EXPECT_NE(motion("3"), motion("4"));
}

} // namespace
} // namespace springdrive::app
