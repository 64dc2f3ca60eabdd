// Covers app/commands/command_line.cpp, from outside.
#include "tests/support/program.h"

#include <gtest/gtest.h>

#include <sstream>
#include <string>
#include <vector>

namespace springdrive::app {
namespace {

TEST(CommandLine, HelpListsTheSubcommands) {
    const testing::Ending help = testing::run_program({"--help"});
    EXPECT_EQ(help.exit_status, 0);
    for (const char *name : {"demo", "figures", "stiffness", "touch", "inspect", "--scene"}) {
        EXPECT_NE(help.out.find(name), std::string::npos) << name << " in\n" << help.out;
    }
    EXPECT_NE(testing::run_program({"stiffness", "--help"}).out.find("--freq-from"),
              std::string::npos);
    EXPECT_NE(testing::run_program({"demo", "--help"}).out.find("--lockstep"), std::string::npos);
    EXPECT_NE(testing::run_program({"--lockstep", "--help"}).out.find("--lockstep"),
              std::string::npos);
}

TEST(CommandLine, ANumberIsReadAsAWholeOrRefused) {
    for (const char *number : {"6,5", "6x5", "6.5.1", "1e", "6 5"}) {
        const testing::Ending ending = testing::run_program({"stability", "--kp", number});
        EXPECT_EQ(ending.exit_status, 2) << number;
        EXPECT_NE(ending.error.find(std::string("--kp = ") + number), std::string::npos)
            << ending.error;
    }
}

TEST(CommandLine, NamesAnUnknownSubcommand) {
    const testing::Ending ending = testing::run_program({"stifness"});
    EXPECT_EQ(ending.exit_status, 2);
    EXPECT_NE(ending.error.find("stifness"), std::string::npos) << ending.error;
}

TEST(CommandLine, SuggestsWhatAMistypedWordMayHaveMeant) {
    const auto said = [](const std::vector<std::string> &arguments) {
        const testing::Ending ending = testing::run_program(arguments);
        EXPECT_EQ(ending.exit_status, 2);
        EXPECT_EQ(std::count(ending.error.begin(), ending.error.end(), '\n'), 1) << ending.error;
        return ending.error;
    };
    for (const auto &arguments :
         std::vector<std::vector<std::string>>{{"--sceen", "x.gltf"},
                                               {"demo", "--sceen", "x.gltf"},
                                               {"--frames", "3", "--sceen=x"}}) {
        EXPECT_NE(said(arguments).find("--sceen is no option of demo; did you mean --scene?"),
                  std::string::npos);
    }
    EXPECT_NE(said({"stifness"}).find("did you mean stiffness?"), std::string::npos);
    EXPECT_NE(said({"stiffness", "--dr", "1"}).find("did you mean --dR?"), std::string::npos);
    EXPECT_EQ(said({"--entirely-else"}).find("did you mean"), std::string::npos);
    EXPECT_NE(said({"record", "a.rec", "b.rec"}).find("b.rec was not expected by record"),
              std::string::npos);
}

TEST(CommandLine, TheDemoTakesAFileWithoutAnOptionByItsKind) {
    const auto folder = testing::fresh_folder("demo_file");
    // As a file manager starts it. What is missing is refused before there is a window.
    testing::expect_refused(testing::run_program({"demo", folder / "none.rec"}),
                            "none.rec: not found; --open takes a record");
    const testing::Ending scene = testing::run_program({"demo", folder / "none.gltf"});
    EXPECT_EQ(scene.exit_status, 1);
    EXPECT_NE(scene.error.find("none.gltf"), std::string::npos) << scene.error;
    EXPECT_EQ(scene.error.find("--open"), std::string::npos) << scene.error;
    for (const char *option : {"--scene", "--open"}) {
        testing::expect_one_line(testing::run_program({"demo", "a.gltf", option, "b.gltf"}), 2,
                                 option);
    }
}

/// Without a board on USB: one that cannot be used is listed, too.
TEST(CommandLine, DeviceTakesWhatDeviceListNames) {
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
    testing::expect_refused(testing::run_program({"device", "info", "--device", "sim:sim-1"}),
                            "must be sim, usb, usb:SERIAL or emulated");
}

TEST(CommandLine, RefusesAnEmptyArgument) {
    for (const std::vector<std::string> &arguments :
         {std::vector<std::string>{"stiffness", "--dR", ""}, {""}, {"--scene", ""}}) {
        const testing::Ending ending = testing::run_program(arguments);
        EXPECT_EQ(ending.exit_status, 2);
        EXPECT_NE(ending.error.find("empty"), std::string::npos) << ending.error;
    }
}

} // namespace
} // namespace springdrive::app
