// Covers what runs a device, from outside: app/main.cpp, app/demo/demo.cpp, and
// app/commands/{record,export,replay,device,sweep,commissioning}_command*.cpp on simulated devices
// and emulated boards; common_options.cpp's warnings; stage/frame_loop.cpp.
#include "app/stage/frame_loop.h"
#include "engine/control/tuning_file.h"
#include "tests/support/csv.h"
#include "tests/support/devices.h"
#include "tests/support/program.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace springdrive::app {
namespace {

class Record : public ::testing::Test {
protected:
    /// In lockstep on the plate: 2500 ticks, of which 1000 touch it.
    std::string make(const std::string &name, std::vector<std::string> more = {}) const {
        more.insert(more.begin(), {"record", folder / name, "--seconds", "2.5", "--scene",
                                   testing::assets() / "scenes/plate.gltf", "--lockstep"});
        const testing::Ending ending = testing::run_program(more);
        EXPECT_EQ(ending.exit_status, 0) << ending.error;
        return folder / name;
    }
    static std::string exported(const std::string &record, const char *columns) {
        return testing::run_program({"export", record, "--csv", "-", "--columns", columns}).out;
    }

    std::filesystem::path folder = testing::fresh_folder("record");
};

TEST_F(Record, IsReplayedToTheLastBitAndExportedInPart) {
    const std::string file = make("touch.rec");
    const testing::Ending same = testing::run_program({"replay", file});
    EXPECT_EQ(same.exit_status, 0) << same.error;
    EXPECT_NE(same.out.find("replayed 2500 ticks"), std::string::npos) << same.out;
    EXPECT_NE(same.out.find("e_W_V                  equal to the last bit"), std::string::npos)
        << same.out;
    EXPECT_EQ(same.out.find("differs"), std::string::npos) << same.out;

    const testing::Ending another =
        testing::run_program({"replay", file, "--kp", "12", "--csv", "-"});
    EXPECT_EQ(another.exit_status, 0) << another.error;
    EXPECT_EQ(std::count(another.out.begin(), another.out.end(), '\n'), 2501);
    EXPECT_NE(another.error.find("e_W_V                  differs in"), std::string::npos)
        << another.error;

    const testing::Ending part =
        testing::run_program({"export", file, "--csv", "-", "--columns", "tick,time_s,e_W*",
                              "--from", "1.0", "--to", "1.009"});
    EXPECT_EQ(part.exit_status, 0) << part.error;
    EXPECT_EQ(part.out.substr(0, part.out.find('\n')), "tick,time_s,e_W1_V,e_W2_V,e_W3_V");
    EXPECT_EQ(std::count(part.out.begin(), part.out.end(), '\n'), 11);
    EXPECT_NE(part.error.find("10 rows of 5 columns"), std::string::npos) << part.error;
    const testing::Ending list = testing::run_program({"export", file, "--list"});
    EXPECT_NE(list.out.find("PHANTOM 1.0"), std::string::npos) << list.out;
    for (const char *format : {"--npy", "--mat"}) {
        const std::string out = folder / (std::string("touch") + format);
        EXPECT_EQ(testing::run_program({"export", file, format, out}).exit_status, 0) << format;
        EXPECT_GT(std::filesystem::file_size(out), 2500U * 8U);
    }

    const std::string before = testing::contents_of(file);
    struct Case {
        std::vector<std::string> words;
        const char *names;
    };
    for (const Case &refused : {
             Case{{"record", file}, "touch.rec"},
             Case{{"export", file}, "--csv"},
             Case{{"export", file, "--csv", "-", "--npy", "x"}, "one of"},
             Case{{"export", file, "--csv", "-", "--columns", "tipp_x_m"}, "tipp_x_m"},
             Case{{"export", file, "--csv", "-", "--from", "2", "--to", "1"}, "--from"},
             Case{{"export", file, "--csv", "/dev/full"}, "/dev/full"},
             Case{{"export", file, "--mat", "/dev/null"}, "/dev/null"},
             Case{{"export", file, "--mat", "-"}, "--mat"},
         }) {
        testing::expect_refused(testing::run_program(refused.words), refused.names);
    }
    EXPECT_TRUE(testing::contents_of(file) == before);
}

TEST_F(Record, OfASampledDeviceIsThatOfItsSeed) {
    const std::string drawn = make("drawn.rec", {"--device-seed", "7"});
    const testing::Ending replayed = testing::run_program({"replay", drawn});
    EXPECT_EQ(replayed.out.find("differs"), std::string::npos) << replayed.out;
    const auto currents = [](const std::string &record) { return exported(record, "current*"); };
    EXPECT_EQ(currents(drawn), currents(make("again.rec", {"--device-seed", "7"})));
    EXPECT_NE(currents(drawn), currents(make("other.rec", {"--device-seed", "8"})));
    EXPECT_EQ(currents(make("nominal.rec")),
              currents(make("without.rec", {"--device-seed", "7", "--without",
                                            "motor_tolerances,commutator_phase,current_sensing,"
                                            "brush_voltage,torque_ripple"})));

    const auto observed = [](const std::string &record) {
        const std::string csv = exported(record, "R_observed*,R_trusted*");
        return csv.substr(csv.rfind('\n', csv.size() - 2) + 1);
    };
    EXPECT_EQ(observed(drawn), "1,1,1,1,1,1\n");
    const std::string unobserved = make("unobserved.rec", {"--without-observer"});
    EXPECT_EQ(observed(unobserved), "0,0,0,1,1,1\n");
    EXPECT_EQ(testing::run_program({"replay", unobserved}).exit_status, 0);
}

TEST_F(Record, ByTheClockIsReplayedToo) {
    const std::string file = folder / "clock.rec";
    const testing::Ending recorded = testing::run_program(
        {"record", file, "--seconds", "1.5", "--servo-hz", "4000", "--json", "-"});
    ASSERT_NE(recorded.out.find("\"jitter\""), std::string::npos) << recorded.error;
    const testing::Ending ending = testing::run_program({"replay", file});
    EXPECT_EQ(ending.exit_status, 0) << ending.out;
}

TEST_F(Record, AStoppedServoIsNoSuccess) {
    std::string device = testing::contents_of(testing::assets() / "devices/phantom_1_0.toml");
    device.replace(device.find("tip_speed_m_per_s = 2.0"), 23, "tip_speed_m_per_s = 0.01");
    std::ofstream(folder / "slow.toml") << device;
    const testing::Ending slow =
        testing::run_program({"record", folder / "stopped.rec", "--seconds", "2.5", "--lockstep",
                              "--device-file", folder / "slow.toml"});
    EXPECT_EQ(slow.exit_status, 1);
    EXPECT_NE(slow.error.find("tip speed"), std::string::npos) << slow.error;
    EXPECT_EQ(testing::run_program({"replay", folder / "stopped.rec"}).exit_status, 0);

    const auto emulated = [&](std::vector<std::string> more) {
        more.insert(more.begin(), {"record", folder / "touch.rec", "--force", "--lockstep",
                                   "--seconds", "4", "--device", "emulated", "--at-zero", "--scene",
                                   testing::assets() / "scenes/plate.gltf"});
        return testing::run_program(more);
    };
    const testing::Ending whole = emulated({"--device-seed", "3", "--without", "gravity"});
    EXPECT_EQ(whole.exit_status, 0) << whole.error;
    const testing::Ending stopped = emulated({"--fault", "stop@2"});
    EXPECT_EQ(stopped.exit_status, 1);
    EXPECT_NE(stopped.error.find("stop switch"), std::string::npos) << stopped.error;
}

/// A tuning file states the rate and the delay for which it was found: a slower rate or a longer
/// delay causes a warning, others do not.
TEST_F(Record, WithATuningOfAFasterOrEarlierServoIsWarnedOf) {
    control::TuningFile file;
    file.margins = control::TuningMargins{1000.0, 1.0, 1.5, 2, 0.25, 0.5, "firm", 0.75};
    std::ostringstream text;
    control::write_tuning_file(text, file);
    std::ofstream(folder / "found.toml") << text.str();
    const auto warning = [&](const char *servo_hz, const char *delay) {
        const testing::Ending ending = testing::run_program(
            {"record", folder / "short.rec", "--force", "--lockstep", "--seconds", "0.01",
             "--tuning-file", folder / "found.toml", "--servo-hz", servo_hz, "--delay", delay});
        EXPECT_EQ(ending.exit_status, 0) << ending.error;
        return ending.error.find("was found for 1000 Hz and a delay of 1") != std::string::npos;
    };
    EXPECT_FALSE(warning("1000", "1"));
    EXPECT_FALSE(warning("2000", "0.5"));
    EXPECT_TRUE(warning("999", "1"));
    EXPECT_TRUE(warning("1000", "1.25"));
}

/// Without a board on USB: one that cannot be used is listed, too.
TEST(DeviceCommand, InfoTakesWhatListNames) {
    const testing::Ending list = testing::run_program({"device", "list"});
    EXPECT_EQ(list.exit_status, 0) << list.error;
    std::istringstream lines(list.out);
    int named = 0;
    for (std::string line; std::getline(lines, line);) {
        const std::string device = line.substr(0, line.find(' '));
        if (!device.starts_with("usb:")) {
            ++named;
            const testing::Ending used =
                testing::run_program({"device", "info", "--device", device});
            EXPECT_EQ(used.exit_status, 0) << line << ": " << used.error;
        }
    }
    EXPECT_EQ(named, 2); // the simulated one, and an emulated board
}

testing::Ending calibrate(std::vector<std::string> more) {
    more.insert(more.begin(), {"device", "calibrate"});
    return testing::run_program(more);
}

TEST(Calibrate, ADeviceFileIsOfOneDevice) {
    const std::filesystem::path folder = testing::fresh_folder("calibrate_file");
    const std::string mine = folder / "mine.toml";
    const testing::Ending made =
        calibrate({"--device-seed", "7", "--air-C", "25", "--out", mine, "--dR", "0.4"});
    ASSERT_EQ(made.exit_status, 0) << made.error << made.out;
    for (const char *part : {"sim-1-7", "dR of 0.4 Ohm", "saved as", "gain", "temperature"}) {
        EXPECT_NE(made.out.find(part), std::string::npos) << part << ":\n" << made.out;
    }
    EXPECT_NE(made.error.find("swing the stylus"), std::string::npos) << made.error;
    const std::string text = testing::contents_of(mine);
    EXPECT_NE(text.find("[calibration]"), std::string::npos);

    testing::expect_refused(calibrate({"--device-seed", "7", "--out", mine}), "--force");
    EXPECT_EQ(testing::contents_of(mine), text);
    const testing::Ending again = calibrate(
        {"--device-seed", "8", "--device-file", mine, "--out", mine, "--force"}); // another one
    EXPECT_EQ(again.exit_status, 0) << again.error;
    const std::string other = testing::contents_of(mine);
    EXPECT_EQ(other.find("[calibration]"), other.rfind("[calibration]"));

    const auto record = [&](const char *name, const char *seed) {
        return testing::run_program({"record", folder / name, "--seconds", "2.5", "--scene",
                                     testing::assets() / "scenes/plate.gltf", "--lockstep",
                                     "--device-seed", seed, "--device-file", mine});
    };
    const testing::Ending recorded = record("touch.rec", "8");
    EXPECT_EQ(recorded.exit_status, 0) << recorded.error;
    const testing::Ending replayed = testing::run_program({"replay", folder / "touch.rec"});
    EXPECT_NE(replayed.out.find("equal to the last bit"), std::string::npos) << replayed.out;
    EXPECT_EQ(replayed.out.find("differs"), std::string::npos) << replayed.out;
    const testing::Ending refused = record("no.rec", "7");
    testing::expect_one_line(refused, 1, "sim-1-8");
    testing::expect_one_line(refused, 1, "sim-1-7");
}

TEST(Calibrate, SaysWhereItIsKeptAndWhyItIsNot) {
    const testing::Ending shown = calibrate({"--device-seed", "3", "--to-board"});
    EXPECT_EQ(shown.exit_status, 0) << shown.error << shown.out;
    EXPECT_NE(shown.out.find("stored on the board"), std::string::npos) << shown.out;
    const testing::Ending early = calibrate({"--device-seed", "3", "--motion-seconds", "1"});
    EXPECT_EQ(early.exit_status, 1) << early.out;
    EXPECT_NE(early.out.find("not calibrated: motor"), std::string::npos) << early.out;
}

/// Of two points of one motor that is known to have no V_b; else R takes a calibration.
testing::Ending sweep(const std::vector<std::string> &options) {
    const std::filesystem::path file =
        testing::write_phantom_without_brushes(testing::fresh_folder("swept"));
    std::vector<std::string> all{"device",      "sweep", "--motors",      "2", "--points", "2",
                                 "--freq-from", "20",    "--device-file", file};
    all.insert(all.end(), options.begin(), options.end());
    return testing::run_program(all);
}

TEST(SweepCommand, WritesPureCsvToStandardOutput) {
    const testing::Ending ending = sweep({"--csv", "-", "--tolerance", "2"});
    ASSERT_EQ(ending.exit_status, 0) << ending.error;
    EXPECT_EQ(ending.out.substr(0, ending.out.find('\n')),
              "motor,freq_hz,measured_mag,measured_phase_deg,deviation_percent,sampled_mag,"
              "sampled_phase_deg,analytic_mag,analytic_phase_deg,magnitude_error_percent,"
              "phase_error_deg,delay_periods,excitation_V");
    const std::vector<std::vector<double>> rows = testing::parsed_numbers(ending.out);
    ASSERT_EQ(rows.size(), 2U);
    for (const std::vector<double> &row : rows) {
        ASSERT_EQ(row.size(), 13U);
        EXPECT_EQ(row[0], 2.0);
        EXPECT_NEAR(row[2], row[5], 0.02 * row[5]); // the promise of docs/commissioning.md
        EXPECT_NEAR(row[3], row[6], 2.0);
        EXPECT_NEAR(row[9], 100.0 * (row[2] / row[5] - 1.0), 1e-4);
        EXPECT_NEAR(row[11], 0.3125, 0.001); // 12.5 loops of the board
    }
}

TEST(SweepCommand, DrawsAChartBesideItsNumbersAndATable) {
    const std::filesystem::path folder = testing::fresh_folder("sweep");
    const testing::Ending ending = sweep({"--svg", folder / "k.svg"});
    ASSERT_EQ(ending.exit_status, 0) << ending.error;
    EXPECT_NE(ending.out.find("motor 2: dR 0."), std::string::npos) << ending.out;
    EXPECT_EQ(testing::contents_of(folder / "k.csv").substr(0, 6), "motor,");
    const std::string svg = testing::contents_of(folder / "k.svg");
    EXPECT_NE(svg.find("</svg>"), std::string::npos);
    EXPECT_NE(svg.find("motor 2, measured"), std::string::npos);
    // Nothing is replaced unasked, and that is known before the device moves.
    testing::expect_refused(sweep({"--svg", folder / "k.svg"}), "k.svg");
}

TEST(SweepCommand, EndsByWhatIsFound) {
    struct Case {
        std::vector<std::string> options;
        int status;
        const char *says;
    };
    for (const Case &one : {
             // R is 2 % above the file's where the sweep is: 9 % of dR.
             Case{{"--without-observer", "--tolerance", "2"}, 1, "sampled form by more than 2 %"},
             Case{{"--without-observer", "--tolerance", "12"}, 0, ""},
             Case{{"--fault", "stop@4"},
                  1,
                  "the device brakes: the device's board reports its stop"},
         }) {
        const testing::Ending ending = sweep(one.options);
        EXPECT_EQ(ending.exit_status, one.status) << one.says;
        EXPECT_NE(ending.error.find(one.says), std::string::npos) << ending.error;
    }
}

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

TEST(LoadProgressPrinter, AFastLoadGoesWithoutAWordAndEndsAtOnce) {
    const auto start = std::chrono::steady_clock::now();
    const scene::LoadProgress progress;
    std::ostringstream out;
    { const LoadProgressPrinter printer("scene.glb", progress, out, std::chrono::hours(1)); }
    EXPECT_EQ(out.str(), "");
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::minutes(1));
}

TEST(LoadProgressPrinter, ASlowOneTellsFileStageAndPercent) {
    scene::LoadProgress progress;
    progress.begin(scene::LoadProgress::Stage::gathering, true);
    progress.advance_to(0.5);
    std::ostringstream out;
    {
        const LoadProgressPrinter printer("scene.glb", progress, out, std::chrono::milliseconds(5));
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
    const std::filesystem::path record = testing::fresh_folder("signal") / "t.rec";
    const testing::Ending ending = testing::run_program( // SIGTERM ends windows in their own tests
        {"--width", "640", "--height", "400", "--record", record}, SIGINT, record);
    EXPECT_EQ(ending.exit_status, 0) << ending.error;
}

} // namespace
} // namespace springdrive::app
