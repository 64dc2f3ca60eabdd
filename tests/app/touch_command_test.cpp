// Covers app/commands/touch_command.cpp and touch_report.cpp, from outside.
#include "tests/support/program.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace springdrive::app {
namespace {

using nlohmann::json;

const std::string kSphere = "sphere:1280";

testing::Ending touch(std::vector<std::string> options) {
    options.insert(options.begin(), "touch");
    return testing::run_program(options);
}

json figures(std::vector<std::string> options) {
    options.insert(options.end(), {"--json", "-"});
    const testing::Ending ending = touch(options);
    EXPECT_EQ(ending.exit_status, 0) << ending.error;
    EXPECT_EQ(ending.error, "");
    return json::parse(ending.out);
}

TEST(TouchCommand, TellsFiguresOfEveryPath) {
    for (const char *path : {"press", "slide", "lissajous", "rain", "random"}) {
        const json said = figures({kSphere, "--path", path, "--steps", "4000", "--check", "20"});
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
}

TEST(TouchCommand, WritesEveryStepAsCsv) {
    const testing::Ending ending = touch({kSphere, "--steps", "300", "--csv", "-"});
    ASSERT_EQ(ending.exit_status, 0) << ending.error;
    std::istringstream lines(ending.out);
    std::string line;
    std::getline(lines, line);
    EXPECT_EQ(line, "t,x,y,z,px,py,pz,nx,ny,nz,constraints,ns,lag,still");
    int rows = 0;
    int touching = 0;
    while (std::getline(lines, line)) {
        std::istringstream cells(line);
        std::vector<double> row;
        for (std::string cell; std::getline(cells, cell, ',');) {
            row.push_back(cell.empty() ? -1.0 : std::stod(cell));
        }
        ASSERT_EQ(row.size(), 14U);
        EXPECT_EQ(row[12] >= 0.0, row[10] > 0.0); // each in contact is checked
        EXPECT_LT(row[12], 1e-6);
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

TEST(TouchCommand, PrintsATable) {
    const testing::Ending ending = touch({kSphere, "--steps", "500", "--seed", "7"});
    ASSERT_EQ(ending.exit_status, 0) << ending.error;
    for (const char *said :
         {"1280 of 1280", "slide", "seed 7", "in contact", "pop-throughs", "stuck", "largest lag",
          "error from sphere", "all that were in contact", "could have been missed (95 %)",
          "longest standstill"}) {
        EXPECT_NE(ending.out.find(said), std::string::npos) << said << " in\n" << ending.out;
    }
}

TEST(TouchCommand, SaysWhatItCouldHaveMissed) {
    const json few = figures({kSphere, "--steps", "3000", "--check", "100"});
    EXPECT_EQ(few["steps_sampled"], 100);
    EXPECT_GT(few["steps_to_sample"], 1000);
    EXPECT_NEAR(few["rate_not_excluded"].get<double>(), 0.0295, 1e-4); // 1 − 0.05^(1/100)
    EXPECT_EQ(few["confidence"], 0.95);
    const json all = figures({kSphere, "--steps", "3000", "--check", "all"});
    EXPECT_EQ(all["steps_sampled"], all["steps_to_sample"]);
    EXPECT_EQ(all["steps_sampled"], all["steps_in_contact"]);
    EXPECT_EQ(all["steps_sampled_lagging"], 0);
    const testing::Ending table = touch({kSphere, "--steps", "3000", "--check", "100"});
    EXPECT_NE(table.out.find("a rate below 1 in 33 could have been missed (95 %)"),
              std::string::npos)
        << table.out;
}

TEST(TouchCommand, FollowsAPathFromAFile) {
    const std::filesystem::path folder = testing::fresh_folder("touch_path");
    std::ofstream(folder / "hand.csv") << "0,0,0.06,0\n0.1,0,0.048,0\n0.2,0,0.06,0\n";
    const json said = figures({kSphere, "--path", folder / "hand.csv"});
    EXPECT_EQ(said["steps"], 201); // both ends of 0.2 s at 1 kHz
    EXPECT_GT(said["steps_in_contact"], 20);
    EXPECT_FALSE(said.contains("seed"));
    EXPECT_EQ(figures({kSphere, "--path", folder / "hand.csv", "--servo-hz", "500"})["steps"], 101);
    EXPECT_EQ(figures({kSphere, "--path", folder / "hand.csv", "--steps", "40"})["steps"], 40);
    testing::expect_refused(touch({kSphere, "--path", folder / "hand.csv", "--speed", "1"}),
                            "--speed");
    std::ofstream(folder / "bad.csv") << "t,x,y,z\n0,0,0.06,0\n1,0,oops,0\n";
    testing::expect_refused(touch({kSphere, "--path", folder / "bad.csv"}), "bad.csv:3:");
    std::ofstream(folder / "long.csv") << "t,x,y,z\n0,0,0.06,0\n5000,0,0,0\n";
    testing::expect_refused(touch({kSphere, "--path", folder / "long.csv"}), "1000000");
    std::filesystem::remove_all(folder);
}

TEST(TouchCommand, RepeatsARunToTheLastBit) {
    const auto motion = [](const std::string &seed) {
        json said = figures({kSphere, "--path", "random", "--steps", "3000", "--seed", seed});
        for (const char *of_the_clock :
             {"preparation_s", "contact_ns", "contact_floor_ns", "free_ns", "free_floor_ns"}) {
            said.erase(of_the_clock);
        }
        return said;
    };
    EXPECT_EQ(motion("3"), motion("3"));
    EXPECT_NE(motion("3"), motion("4"));
}

TEST(TouchCommand, WritesToFiles) {
    const std::filesystem::path folder = testing::fresh_folder("touch_files");
    const testing::Ending ending = touch({kSphere, "--steps", "100", "--csv", folder / "steps.csv",
                                          "--json", folder / "figures.json", "--strict"});
    EXPECT_EQ(ending.exit_status, 0) << ending.error;
    EXPECT_EQ(ending.out, "");
    EXPECT_EQ(testing::contents_of(folder / "steps.csv").substr(0, 7), "t,x,y,z");
    EXPECT_EQ(json::parse(testing::contents_of(folder / "figures.json"))["steps"], 100);
    std::filesystem::remove_all(folder);
}

TEST(TouchCommand, TouchesAFile) {
    const std::string scene = SPRINGDRIVE_ASSET_DIR "/scenes/stepped_block.gltf";
    const json said = figures({scene, "--path", "press", "--steps", "3000"});
    EXPECT_GT(said["steps_in_contact"], 100);
    EXPECT_FALSE(said.contains("largest_sphere_direction_error_deg"));
}

TEST(TouchCommand, SaysWhatIsWrongInOneLine) {
    testing::expect_refused(touch({}), "scene");
    testing::expect_refused(touch({"none.glb"}), "none.glb");
    testing::expect_refused(touch({"sphere:1000"}), "1310720");
    testing::expect_refused(touch({kSphere, "--path", "slid"}), "slid");
    testing::expect_refused(touch({kSphere, "--speed", "0"}), "--speed");
    testing::expect_refused(touch({kSphere, "--speed", "101"}), "--speed");
    testing::expect_refused(touch({kSphere, "--speed", "nan"}), "--speed");
    testing::expect_refused(touch({kSphere, "--depth", "-1e-3"}), "--depth");
    testing::expect_refused(touch({kSphere, "--depth", "1.1"}), "--depth");
    testing::expect_refused(touch({kSphere, "--radius", "-1e-3"}), "--radius");
    testing::expect_refused(touch({kSphere, "--radius", "0.11"}), "--radius");
    testing::expect_refused(touch({kSphere, "--steps", "0"}), "--steps");
    testing::expect_refused(touch({kSphere, "--steps", "1000001"}), "--steps");
    testing::expect_refused(touch({kSphere, "--steps", "1.5"}), "--steps");
    testing::expect_refused(touch({kSphere, "--check", "-1"}), "--check");
    testing::expect_refused(touch({kSphere, "--check", "any"}), "--check any");
    testing::expect_refused(touch({kSphere, "--check", "1000001"}), "--check");
    testing::expect_refused(touch({kSphere, "--slack", "1e-12"}), "--slack");
    testing::expect_refused(touch({kSphere, "--slack", "6e-9"}), "--slack");
    testing::expect_refused(touch({kSphere, "--servo-hz", "249"}), "250");
    testing::expect_refused(touch({kSphere, "--seed", "-1"}), "--seed");
    testing::expect_refused(touch({kSphere, "--csv", "-", "--json", "-"}), "--json");
    testing::expect_refused(touch({kSphere, "--steps", "9", "--csv", "/no/such/folder/t.csv"}),
                            "/no/such/folder");
    testing::expect_refused(touch({kSphere, "--steps", "9", "--json", "/dev/full"}), "/dev/full");
    testing::expect_refused(touch({kSphere, "--device-file", "none.toml"}), "none.toml");
    testing::expect_refused(touch({kSphere, "more"}), "more");
}

} // namespace
} // namespace springdrive::app
