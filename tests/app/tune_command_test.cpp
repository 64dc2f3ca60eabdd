// Covers app/commands/tune_command.cpp, from outside, and its check that the output is writable.
#include "app/commands/output_files.h"
#include "app/commands/tune_report.h"
#include "engine/control/tuning.h"
#include "engine/control/tuning_file.h"
#include "engine/lab/limits/auto_tune.h"
#include "engine/lab/limits/stability_simulation.h"
#include "tests/support/devices.h"
#include "tests/support/program.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

namespace springdrive::app {
namespace {

testing::Ending tune(std::vector<std::string> options) {
    options.insert(options.begin(), "tune");
    return testing::run_program(options);
}

/// Both outputs of the tuning, and its use by every command. The whole search takes seconds.
TEST(TuneCommand, WritesATuningThatIsStable) {
    const std::filesystem::path folder = testing::fresh_folder("tune");
    const std::filesystem::path file = folder / "found.toml";
    const testing::Ending told =
        tune({"--servo-hz", "500", "--dR", "0.8", "--margin", "1.5", "--out", file});
    ASSERT_EQ(told.exit_status, 0) << told.error;
    EXPECT_EQ(told.out.substr(0, 4), "K_P ") << told.out;
    EXPECT_NE(told.out.find("margins: "), std::string::npos) << told.out;

    const control::TuningFile found = control::read_whole_tuning_file(file);
    EXPECT_EQ(control::validate(found.tuning), "");
    EXPECT_EQ(found.tuning.dR_Ohm, 0.8);
    ASSERT_TRUE(found.margins);
    EXPECT_NEAR(found.margins->servo_hz, 500.0, 1e-9);
    EXPECT_GE(found.margins->gain, 1.5 * (1.0 - 1e-3));
    loops::StabilityCase which;
    which.device = testing::phantom_1_0();
    which.tuning = found.tuning;
    which.period_s = 1.0 / 500.0;
    for (const loops::Freedom freedom : {loops::Freedom::one_motor, loops::Freedom::three_motors}) {
        which.freedom = freedom;
        EXPECT_TRUE(loops::is_stable(which));
    }

    const testing::Ending stable =
        testing::run_program({"stability", "--tuning-file", file, "--servo-hz", "500"});
    EXPECT_EQ(stable.exit_status, 0) << stable.out << stable.error;

    const testing::Ending to_standard_output =
        tune({"--servo-hz", "500", "--dR", "0.8", "--margin", "1.5"});
    EXPECT_EQ(to_standard_output.out, testing::contents_of(file))
        << "the report is on a separate stream";
    EXPECT_EQ(to_standard_output.error.substr(0, 4), "K_P ") << to_standard_output.error;
    std::filesystem::remove_all(folder);
}

TEST(TuneCommand, SaysByHowManyPerCentCountsHeldItBack) {
    limits::AutoTuned found;
    const auto said = [&found] {
        std::ostringstream text;
        write_tuned(text, found);
        return text.str();
    };
    EXPECT_EQ(said().find(" %"), std::string::npos) << said();
    found.taken_back = 0.07;
    EXPECT_NE(said().find("K_P is 7 % below"), std::string::npos) << said();
    EXPECT_EQ(said().find("end of its range"), std::string::npos) << said();
    found.tuning.K_P_V_per_rad = limits::AutoTuneRequest{}.max_K_P_V_per_rad;
    EXPECT_NE(said().find("end of its range"), std::string::npos) << said();
}

TEST(TuneCommand, SaysWhatIsWrongInOneLine) {
    testing::expect_refused(tune({"--dR", "0"}), "0.02 to 2.18");
    testing::expect_refused(tune({"--dR", "nan"}), "--dR");
    testing::expect_refused(tune({"--servo-hz", "249"}), "250");
    testing::expect_refused(tune({"--servo-hz", "nan"}), "250");
    testing::expect_refused(tune({"--delay", "-1"}), "--delay");
    testing::expect_refused(tune({"--delay", "9"}), "--delay");
    testing::expect_refused(tune({"--margin", "0.9"}), "1 to 10");
    testing::expect_refused(tune({"--margin", "11"}), "1 to 10");
    testing::expect_refused(tune({"--margin", "nan"}), "--margin");
    testing::expect_refused(tune({"--kinematics", "forward"}), "--kinematics");
    testing::expect_refused(tune({"--device-file", "none.toml"}), "none.toml");
    testing::expect_refused(tune({"--out", "/no/such/folder/t.toml"}), "/no/such/folder");
}

/// Before the search, which would print its progress and result.
TEST(TuneCommand, RefusesAtOnceWhatItCouldNotWrite) {
    const std::filesystem::path folder = testing::fresh_folder("tune_targets");
    testing::expect_refused(tune({"--out", folder}), "is a folder");
    testing::expect_refused(tune({"--out", folder / ""}), "is a folder");
    testing::expect_refused(tune({"--out", folder / std::string(300, 'x')}), "cannot be written");
    testing::expect_refused(tune({"--out", folder / "none" / "t.toml"}),
                            "its folder does not exist");
    testing::expect_refused(tune({"--out", "/proc/x.toml"}),
                            "/proc/x.toml: cannot be written"); // also by root
    EXPECT_TRUE(std::filesystem::is_empty(folder));
    std::filesystem::remove_all(folder);
}

/// An existing file is kept until a tuning is found, and no other file is created.
TEST(TuneCommand, LeavesFilesAsTheyAreWhenItLooksWhetherItCouldWrite) {
    const std::filesystem::path folder = testing::fresh_folder("tune_existing");
    const std::filesystem::path file = folder / "mine.toml";
    std::ofstream(file) << "mine";
    const auto written = std::filesystem::last_write_time(file);
    for (const std::filesystem::path &output :
         {file, folder / "new.toml", std::filesystem::path("/dev/null"),
          std::filesystem::path("new.toml"), std::filesystem::path("-"), std::filesystem::path()}) {
        EXPECT_NO_THROW(check_outputs({{}, {}, {output}}, Existing::replace));
    }
    EXPECT_EQ(testing::contents_of(file), "mine");
    EXPECT_EQ(std::filesystem::last_write_time(file), written);
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 1);
    std::filesystem::remove_all(folder);
}

} // namespace
} // namespace springdrive::app
