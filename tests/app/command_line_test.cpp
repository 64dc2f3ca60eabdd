// Covers app/commands/{command_line,manual}.cpp: help, manual page and completion have what the
// command line has.
#include "app/commands/command_line.h"

#include "tests/support/files.h"
#include "tests/support/program.h"

#include <gtest/gtest.h>

#include <CLI/CLI.hpp>

#include <cstdio>
#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace springdrive::app {
namespace {

TEST(CommandLine, HelpAndVersionArePlainText) {
    struct Case {
        std::vector<std::string> words;
        std::vector<const char *> says;
    };
    for (const Case &one :
         {Case{{"--help"}, {"demo", "figures", "stiffness", "touch", "inspect", "--scene"}},
          Case{{"stiffness", "--help"}, {"--freq-from"}},
          Case{{"--lockstep", "--help"}, {"--lockstep"}},
          Case{{"--version"}, {SPRINGDRIVE_VERSION}}}) {
        const testing::Ending help = testing::run_program(one.words);
        EXPECT_EQ(help.exit_status, 0);
        for (const char *part : one.says) {
            EXPECT_NE(help.out.find(part), std::string::npos) << part << " in\n" << help.out;
        }
        for (const char c : help.out) {
            EXPECT_TRUE(c == '\n' || static_cast<unsigned char>(c) >= 0x20) << help.out;
        }
    }
}

std::string manual() {
    std::ostringstream out;
    write_manual(out, *command_tree());
    return out.str();
}

std::size_t count(const std::string &text, const std::string &part) {
    std::size_t found = 0;
    for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) {
        ++found;
    }
    return found;
}

TEST(Manual, NamesEveryCommandAndOption) {
    const std::string page = manual();
    const auto program = command_tree();
    std::size_t options = 0;
    for (const CLI::App *command : program->get_subcommands(nullptr)) {
        EXPECT_EQ(count(page, "\n.SS springdrive " + command->get_name() + "\n"), 1U);
        for (const CLI::Option *option : command->get_options()) {
            for (const std::string &name : option->get_lnames()) {
                std::string escaped = "\\-\\-";
                for (const char letter : name) {
                    escaped += letter == '-' ? "\\-" : std::string(1, letter);
                }
                EXPECT_NE(page.find(escaped), std::string::npos) << name;
                ++options;
            }
        }
    }
    EXPECT_GT(options, 100U);
    EXPECT_EQ(count(page, "\n.SS springdrive device emulate\n"), 1U);
    EXPECT_NE(page.find("\n.SH FILES\n"), std::string::npos);
    EXPECT_EQ(page.find("{false}"), std::string::npos) << "a name that cannot be typed";
}

TEST(Manual, HasNoLineThatTroffWouldTakeForARequestByMistake) {
    const std::set<std::string> requests{".TH", ".SH", ".SS", ".TP", ".PP",  ".B",
                                         ".nh", ".ad", ".nf", ".fi", ".\\\""};
    std::istringstream page(manual());
    for (std::string line; std::getline(page, line);) {
        ASSERT_FALSE(line.starts_with("'")) << line;
        EXPECT_TRUE(!line.starts_with(".") || requests.contains(line.substr(0, line.find(' '))))
            << line;
    }
}

/// What bash offers for the last of these words.
std::string completed(const std::filesystem::path &script, const std::vector<std::string> &words) {
    std::string command = "bash -c 'source " + script.string() + "; COMP_WORDS=(springdrive";
    for (const std::string &word : words) {
        command += " \"" + word + "\"";
    }
    command += "); COMP_CWORD=" + std::to_string(words.size()) +
               "; _springdrive; echo \"${COMPREPLY[*]}\"' 2>&1";
    FILE *const pipe = popen(command.c_str(), "r");
    std::string answer;
    for (int letter = std::fgetc(pipe); letter != EOF; letter = std::fgetc(pipe)) {
        answer += static_cast<char>(letter);
    }
    EXPECT_EQ(pclose(pipe), 0) << command;
    return answer.substr(0, answer.find('\n'));
}

TEST(Completion, OffersCommandsOptionsValuesAndFiles) {
    const std::filesystem::path folder = testing::fresh_folder("completion");
    const std::string file = folder / "my.gltf";
    std::ofstream(file) << "{}";
    const std::string begun = folder / "my";
    std::ofstream(folder / "script") << [] {
        std::ostringstream out;
        write_bash_completion(out, *command_tree());
        return out.str();
    }();
    struct Case {
        std::vector<std::string> words;
        std::string offered;
    };
    for (const Case &one : {
             Case{{"sti"}, "stiffness"},
             Case{{"nothing"}, ""},
             Case{{"demo", "--locks"}, "--lockstep"},
             Case{{"stiffness", "--locks"}, ""},
             Case{{"--locks"}, "--lockstep"}, // without a command, those of demo
             Case{{"demo", "--model", ""}, "full auto"},
             Case{{"demo", "--model", "=", "a"}, "auto"},
             Case{{"demo", "--model", "="}, "full auto"},
             Case{{"demo", "--without", "gravity,vis"}, "gravity,viscous_friction"},
             Case{{"demo", "--seconds", ""}, ""},
             Case{{"device", "emu"}, "emulate"},
             Case{{"device", "emulate", "--clock", "w"}, "wall"},
             Case{{"demo", "--scene", begun}, file},
             Case{{"demo", begun}, file},
             Case{{"inspect", begun}, file},
             Case{{"demo", "--servo-hz", begun}, ""},
             Case{{"stiffness", begun}, ""},
         }) {
        EXPECT_EQ(completed(folder / "script", one.words), one.offered) << one.words.back();
    }
    EXPECT_NE(completed(folder / "script", {""}).find("stability"), std::string::npos);
}

} // namespace
} // namespace springdrive::app
