// Covers app/main.cpp, app/commands/command_line.cpp, app/demo/demo.cpp: the program from outside.
#include "tests/support/devices.h"
#include "tests/support/program.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace springdrive::app {
namespace {

bool has_display() {
    return std::getenv("DISPLAY") != nullptr ||       // NOLINT(concurrency-mt-unsafe)
           std::getenv("WAYLAND_DISPLAY") != nullptr; // NOLINT(concurrency-mt-unsafe)
}

void expect_plain_text(const std::string &text) {
    for (const char c : text) {
        EXPECT_TRUE(c == '\n' || static_cast<unsigned char>(c) >= 0x20) << text;
    }
}

void expect_one_clear_line(const testing::Ending &ending, const std::string &names) {
    EXPECT_GT(ending.exit_status, 0);
    EXPECT_EQ(std::count(ending.error.begin(), ending.error.end(), '\n'), 1) << ending.error;
    EXPECT_EQ(ending.error.substr(0, 13), "springdrive: ") << ending.error;
    EXPECT_NE(ending.error.find(names), std::string::npos) << ending.error;
    EXPECT_EQ(ending.out, "");
    expect_plain_text(ending.error);
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
    expect_one_clear_line(testing::run_program({"--scene", (folder / "none.glb").string()}),
                          "none.glb");
    const auto refused = [&folder](const std::string &name, const std::string &text) {
        const testing::Ending ending =
            testing::run_program({"demo", "--scene", written(folder, name, text)});
        expect_one_clear_line(ending, name);
        return ending.error;
    };
    refused("text.glb", "this is a shopping list\nmilk\n");
    refused("empty.glb", "");
    refused("half.gltf", sphere.substr(0, sphere.size() / 2));
    refused("index.gltf", one_triangle(kIndexNine, 3, "4"));
    refused("nan.gltf", one_triangle(kNan, 3, "4"));
    refused("points.gltf", one_triangle(kGood, 3, "0"));
    std::string glb = "glTF";
    glb += std::string("\x02\0\0\0\xff\xff\0\0\x10\0\0\0JSON{\"asset\":", 24);
    refused("truncated.glb", glb);
    std::filesystem::remove_all(folder);
}

TEST(Program, SaysWhatIsWrongWithAnOptionInOneLine) {
    expect_one_clear_line(testing::run_program({"--frams", "3"}), "frams");
    // A scene that is ready before any computer would tell how far it is with loading.
    const auto expect_refusal = [](std::vector<std::string> typed, const std::string &names) {
        typed.insert(typed.end(), {"--scene", testing::assets() / "scenes/plate.gltf"});
        expect_one_clear_line(testing::run_program(typed), names);
    };
    expect_refusal({"--servo-hz", "99"}, "250");
    expect_refusal({"--servo-hz", "fast"}, "fast");
    expect_refusal({"--dR", "0"}, "--dR");
    expect_refusal({"--kp", "nan"}, "K_P");
    expect_refusal({"--map", "sideways"}, "sideways");
    expect_refusal({"--map", "0"}, "transpose");
    expect_refusal({"--alpha-mode", "often"}, "by_hand");
    expect_refusal({"--servo-hz", "nan"}, "10000");
    expect_refusal({"--servo-hz", "-5"}, "10000");
    expect_refusal({"--servo-hz", "inf"}, "10000");
    expect_refusal({"--delay", "-1"}, "delay");
    expect_refusal({"--device", "usb:none such"}, "USB");
    expect_refusal({"--device", "serial"}, "serial");
    expect_refusal({"--device", "usb", "--delay", "1"}, "--delay");
    expect_refusal({"--device-file", "none.toml"}, "none.toml");
    expect_refusal({"--tuning-file", "none.toml"}, "none.toml");
    expect_refusal({"--path", "none.csv"}, "none.csv");
    expect_refusal({"--lockstep"}, "--frames");
    expect_refusal({"--frames", "-3"}, "frames");
    expect_refusal({"record", "/no/such/folder/t.rec"}, "/no/such");
}

TEST(Program, HelpAndVersionSucceed) {
    const testing::Ending help = testing::run_program({"--help"});
    EXPECT_EQ(help.exit_status, 0);
    EXPECT_NE(help.out.find("--scene"), std::string::npos);
    expect_plain_text(help.out);
    EXPECT_EQ(testing::run_program({"demo", "--help"}).exit_status, 0);
    EXPECT_EQ(testing::run_program({"--version"}).exit_status, 0);
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
    std::istringstream telemetry(telemetry_of(folder / "t.rec"));
    std::string line;
    std::string last;
    std::getline(telemetry, line);
    const auto column = [header = line](const std::string &name, const std::string &row) {
        const auto before = std::count(
            header.begin(), header.begin() + static_cast<std::ptrdiff_t>(header.find(name)), ',');
        std::size_t at = 0;
        for (std::ptrdiff_t i = 0; i < before; ++i) {
            at = row.find(',', at) + 1;
        }
        return std::stod(row.substr(at));
    };
    while (std::getline(telemetry, line)) {
        last = line;
    }
    // At rest with its target, to an encoder count.
    EXPECT_NEAR(column("tip_x_m", last), 0.03, 5e-5);
    EXPECT_NEAR(column("tip_y_m", last), 0.08, 5e-5);
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

TEST_F(Demo, AScreenshotThatCannotBeWrittenIsSaid) {
    const testing::Ending ending = testing::run_program({"--lockstep", "--frames", "2", "--scene",
                                                         testing::assets() / "scenes/plate.gltf",
                                                         "--screenshot", "/no/such/folder/s.png"});
    expect_one_clear_line(ending, "/no/such/folder/s.png");
}

} // namespace
} // namespace springdrive::app
