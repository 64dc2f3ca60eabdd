// Covers app/commands/chart_command.cpp: `springdrive chart` from outside.
#include "engine/lab/charts/charts.h"
#include "tests/support/devices.h"
#include "tests/support/program.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <set>
#include <string>
#include <vector>

namespace springdrive::app {
namespace {

/// The quickest charts.
constexpr const char *kQuick = "motion_stiffness,servo_rate_direction";

testing::Ending chart(const std::filesystem::path &out, std::vector<std::string> more = {}) {
    more.insert(more.begin(), {"chart", "--out", out.string()});
    return testing::run_program(more);
}

std::set<std::string> files_in(const std::filesystem::path &folder) {
    std::set<std::string> names;
    for (const auto &file : std::filesystem::directory_iterator(folder)) {
        names.insert(file.path().filename());
    }
    return names;
}

TEST(Charts, ThoseAskedForComeOutAsPicturesAndNumbers) {
    const std::filesystem::path folder = testing::fresh_folder("charts") / "new";
    const testing::Ending ending = chart(folder, {"--only", kQuick, "--repeats", "2"});
    ASSERT_EQ(ending.exit_status, 0) << ending.error;
    EXPECT_EQ(ending.out, "");
    EXPECT_EQ(files_in(folder),
              (std::set<std::string>{"motion_stiffness.csv", "motion_stiffness.svg",
                                     "servo_rate_direction.csv", "servo_rate_direction.svg"}));
    const std::string svg = testing::contents_of(folder / "motion_stiffness.svg");
    for (const char *part : {"PHANTOM 1.0", "minimum of 2 repetitions", "inverse (18)",
                             "transpose, α by hand", "α 1000"}) {
        EXPECT_NE(svg.find(part), std::string::npos) << part;
    }
    const std::string csv = testing::contents_of(folder / "motion_stiffness.csv");
    EXPECT_TRUE(csv.starts_with("method,setting,cost_least_ns,cost_median_ns,cost_greatest_ns,"
                                "error,stable,machine\n"));
    EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 9); // a header, three and five points
    std::filesystem::remove_all(folder.parent_path());
}

TEST(Charts, TakeTheDeviceAndTheTuning) {
    const std::filesystem::path folder = testing::fresh_folder("premium");
    const testing::Ending ending =
        chart(folder, {"--only", "servo_rate_direction", "--device-file",
                       testing::assets() / "devices/phantom_premium_1_5.toml", "--tuning-file",
                       testing::assets() / "tunings/soft.toml"});
    ASSERT_EQ(ending.exit_status, 0) << ending.error;
    EXPECT_NE(testing::contents_of(folder / "servo_rate_direction.svg").find("Premium 1.5"),
              std::string::npos);
    std::filesystem::remove_all(folder);
}

TEST(Charts, SayWhatIsWrongInOneLine) {
    const std::filesystem::path folder = testing::fresh_folder("wrong_charts");
    std::ofstream(folder / "file") << "in the way";
    testing::expect_one_line(testing::run_program({"chart"}), 2, "--out");
    testing::expect_one_line(chart(folder / "file" / "below"), 1, "below");
    testing::expect_one_line(chart(folder, {"--only", "everything"}), 2, "servo_rate_stiffness");
    testing::expect_one_line(chart(folder, {"--repeats", "0"}), 1,
                             "--repeats is 0; it must be from 1 to");
    testing::expect_one_line(chart(folder, {"--repeats", "101"}), 1, "100");
    testing::expect_one_line(chart(folder, {"--repeats", "many"}), 2, "--repeats");
    testing::expect_one_line(chart(folder, {"--tuning-file", "none.toml"}), 1, "none.toml");
    std::filesystem::create_symlink("/dev/full", folder / "motion_stiffness.csv");
    testing::expect_one_line(chart(folder, {"--only", kQuick}), 1, "motion_stiffness.csv");
    std::filesystem::remove_all(folder);
}

TEST(Charts, WithoutGnuplotTheNumbersStay) {
    const std::filesystem::path folder = testing::fresh_folder("charts_no_gnuplot");
    const char *inherited = std::getenv("PATH"); // NOLINT(concurrency-mt-unsafe)
    const std::string path = inherited != nullptr ? inherited : "";
    setenv("PATH", folder.c_str(), 1); // NOLINT(concurrency-mt-unsafe)
    const testing::Ending ending = chart(folder / "out", {"--only", kQuick, "--repeats", "1"});
    setenv("PATH", path.c_str(), 1); // NOLINT(concurrency-mt-unsafe)
    testing::expect_one_line(ending, 1, "gnuplot-nox");
    EXPECT_EQ(files_in(folder / "out"),
              (std::set<std::string>{"motion_stiffness.csv", "servo_rate_direction.csv"}));
    std::filesystem::remove_all(folder);
}

TEST(Charts, AreNamedAsTheListSays) {
    charts::ChartSetting setting;
    setting.device = testing::phantom_1_0();
    setting.repeats = 1;
    std::set<std::string_view> names;
    for (const charts::ChartMaker &maker : charts::kCharts) {
        EXPECT_TRUE(names.insert(maker.name).second) << maker.name;
        if (maker.name.starts_with("servo_rate") || maker.name.starts_with("motion")) {
            EXPECT_EQ(maker.make(setting, [](double) {}).name, maker.name);
        }
    }
}

} // namespace
} // namespace springdrive::app
