// Covers app/commands/doctor_command.cpp and app/doctor/probe.cpp, from outside: on this computer,
// whatever it is.
#include "tests/support/files.h"
#include "tests/support/program.h"
#include "tests/support/variable.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace springdrive::app {
namespace {

using nlohmann::json;

testing::Ending run_doctor(std::vector<std::string> options) {
    options.insert(options.begin(), {"doctor", "--folder", testing::fresh_folder("doctor")});
    return testing::run_program(options);
}

json judged(const std::vector<std::string> &options, int expected_status = -1) {
    std::vector<std::string> all = options;
    all.emplace_back("--json");
    const testing::Ending ending = run_doctor(all);
    EXPECT_EQ(ending.error, "");
    const json said = json::parse(ending.out);
    EXPECT_EQ(ending.exit_status, said["failures"] == 0 ? 0 : 1);
    if (expected_status >= 0) {
        EXPECT_EQ(ending.exit_status, expected_status) << ending.out;
    }
    return said;
}

json check_of(const json &said, const std::string &id) {
    for (const json &check : said["checks"]) {
        if (check["id"] == id) {
            return check;
        }
    }
    ADD_FAILURE() << "no check " << id << " in " << said.dump(2);
    return {};
}

TEST(DoctorCommand, EveryCheckHasItsFieldsAndEveryFaultItsLine) {
    const json said = judged({"--no-window"});
    for (const char *const id :
         {"rt_priority", "memory_lock", "rt_share", "preemption", "idle", "governor", "usb_board",
          "display", "opengl", "disk", "gnuplot", "font"}) {
        check_of(said, id);
    }
    for (const json &check : said["checks"]) {
        const bool is_wrong = check["verdict"] == "failure" || check["verdict"] == "warning";
        EXPECT_NE(check["mend"].get<std::string>().empty(), is_wrong) << check.dump(2);
        EXPECT_NE(check["found"], "") << check.dump(2);
        EXPECT_NE(check["matters"], "") << check.dump(2);
        EXPECT_EQ(check["mend"].get<std::string>().find('\n'), std::string::npos);
    }
    EXPECT_EQ(said["device"], "sim");
    EXPECT_EQ(said["servo_hz"], 1000.0);
}

TEST(DoctorCommand, TextNamesEachCheck) {
    const testing::Ending ending = run_doctor({"--no-window"});
    EXPECT_EQ(ending.error, "");
    for (const char *const title : {"real-time priority: ", "memory lock: ", "OpenGL: ",
                                    "disk for records in ", "--device sim at 1000 Hz"}) {
        EXPECT_NE(ending.out.find(title), std::string::npos) << title << " in\n" << ending.out;
    }
}

TEST(DoctorCommand, AnAbsentBoardFailsOnlyForUsb) {
    const json usb = judged({"--device", "usb:no such board", "--no-window"}, 1);
    EXPECT_EQ(check_of(usb, "usb_board")["verdict"], "failure");
    EXPECT_EQ(usb["device"], "usb:no such board");
    EXPECT_NE(check_of(judged({"--no-window"}), "usb_board")["verdict"], "failure");
}

TEST(DoctorCommand, WithoutADisplayOnlyTheWindowFails) {
    const testing::Variable none("DISPLAY", std::nullopt);
    EXPECT_EQ(check_of(judged({}, 1), "display")["verdict"], "failure");
    EXPECT_EQ(check_of(judged({"--no-window"}), "display")["verdict"], "not applicable");
    const testing::Variable absent("DISPLAY", ":73519");
    EXPECT_NE(check_of(judged({}, 1), "display")["found"].get<std::string>().find(":73519"),
              std::string::npos);
}

TEST(DoctorCommand, AFolderThatCannotBeWrittenToFails) {
    const std::filesystem::path folder = testing::fresh_folder("doctor_disk");
    const auto disk = [](const std::string &where) {
        const testing::Ending ending =
            testing::run_program({"doctor", "--no-window", "--json", "--folder", where});
        EXPECT_EQ(ending.exit_status, 1) << where;
        return check_of(json::parse(ending.out), "disk");
    };
    EXPECT_EQ(disk(folder / "none")["mend"], "mkdir -p " + (folder / "none").string());
    std::ofstream(folder / "file") << "x";
    EXPECT_EQ(disk(folder / "file")["verdict"], "failure");
    EXPECT_EQ(disk("/proc")["verdict"], "failure");
}

TEST(DoctorCommand, TakesAtMostThreeSecondsWithADisplayThatNeverAnswers) {
    // An address that nobody has.
    const testing::Variable silent("DISPLAY", "203.0.113.1:0");
    const auto start = std::chrono::steady_clock::now();
    EXPECT_EQ(check_of(judged({}, 1), "display")["verdict"], "failure");
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(6)); // busy computers
}

} // namespace
} // namespace springdrive::app
