// Covers app/commands/baseline_command.cpp and drive_comparison, from outside.
#include "tests/support/csv.h"
#include "tests/support/files.h"
#include "tests/support/program.h"

#include <gtest/gtest.h>

#include <map>
#include <ranges>
#include <string>
#include <vector>

namespace springdrive::app {
namespace {

testing::Ending baseline(std::vector<std::string> options) {
    options.insert(options.begin(), "baseline");
    return testing::run_program(options);
}

/// At 250 Hz, where tuning is fast: three drives, with the count force of the quiet one not above
/// that of the spring drive.
TEST(BaselineCommand, ComparesThreeDrives) {
    const testing::Ending ending =
        baseline({"--servo-hz", "250", "--delay", "1", "--dR", "0.8", "--csv", "-"});
    ASSERT_EQ(ending.exit_status, 0) << ending.error;
    const auto lines = testing::parsed_csv(ending.out);
    const std::vector<std::string> &names = lines.front();
    std::map<std::string, std::map<std::string, std::string>> drives;
    for (const std::vector<std::string> &values : lines | std::views::drop(1)) {
        ASSERT_EQ(values.size(), names.size());
        for (std::size_t i = 0; i < names.size(); ++i) {
            drives[values[3]][names[i]] = values[i];
        }
    }
    ASSERT_EQ(drives.size(), 3U);
    EXPECT_EQ(drives.at("spring").at("delay_periods"), "1");
    const auto value = [&](const std::string &drive, const std::string &name) {
        return std::stod(drives.at(drive).at(name));
    };
    // (14) is caused by the inductance, which a current drive does not use.
    EXPECT_GT(value("spring", "K_HF_N_per_m"), 1e4);
    EXPECT_EQ(value("current", "K_HF_N_per_m"), 0.0);
    // The static stiffness of a wall is that to which it was tuned.
    EXPECT_NEAR(value("current", "K_DC_N_per_m"), value("current", "wall_K_N_per_m"),
                1e-4 * value("current", "wall_K_N_per_m"));
    EXPECT_LE(value("current, as quiet", "count_N"), value("spring", "count_N") * (1.0 + 1e-5));
    EXPECT_LE(value("current, as quiet", "K_DC_N_per_m"), value("current", "K_DC_N_per_m") * 1.01);
    // Free space: the lag adds mass with the spring drive, and none with the current drive.
    EXPECT_GT(value("spring", "apparent_mass_kg"), value("current", "apparent_mass_kg"));
}

TEST(BaselineCommand, RefusesWhatCannotBe) {
    testing::expect_refused(baseline({"--servo-hz", "100"}), "250 to 10000");
    testing::expect_refused(baseline({"--delay", "9"}), "from 0 to 8");
    testing::expect_refused(baseline({"--dR", "0"}), "dR is 0");
    testing::expect_refused(baseline({"--margin", "0.5"}), "from 1 to 10");
    const std::string file = testing::fresh_folder("baseline_refused") / "none" / "x.csv";
    testing::expect_refused(baseline({"--csv", file}), file);
}

} // namespace
} // namespace springdrive::app
