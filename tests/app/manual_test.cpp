// Covers app/commands/manual.cpp: manual page and completion have what the command line has.
#include "app/commands/manual.h"

#include "app/commands/command_line.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>

#include <CLI/CLI.hpp>

#include <cstdio>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace springdrive::app {
namespace {

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

/// What bash offers for the last of these words.
std::string completed(const std::vector<std::string> &words) {
    static const std::filesystem::path script = [] {
        std::filesystem::path file = testing::fresh_folder("completion") / "springdrive";
        std::ofstream out(file);
        write_bash_completion(out, *command_tree());
        return file;
    }();
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
    std::istringstream page(manual());
    for (std::string line; std::getline(page, line);) {
        ASSERT_FALSE(line.starts_with("'")) << line;
        if (line.starts_with(".")) {
            const std::string request = line.substr(0, line.find(' '));
            EXPECT_TRUE(request == ".TH" || request == ".SH" || request == ".SS" ||
                        request == ".TP" || request == ".PP" || request == ".B" ||
                        request == ".nh" || request == ".ad" || request == ".nf" ||
                        request == ".fi" || request == ".\\\"")
                << line;
        }
    }
}

TEST(Completion, OffersCommandsOptionsAndValues) {
    EXPECT_EQ(completed({"sti"}), "stiffness");
    EXPECT_EQ(completed({"nothing"}), "");
    EXPECT_NE(completed({""}).find("stability"), std::string::npos);
    EXPECT_EQ(completed({"demo", "--locks"}), "--lockstep");
    EXPECT_EQ(completed({"stiffness", "--locks"}), "");
    EXPECT_EQ(completed({"--locks"}), "--lockstep"); // without a command, those of demo
    EXPECT_EQ(completed({"demo", "--model", ""}), "full auto");
    EXPECT_EQ(completed({"demo", "--model", "=", "a"}), "auto");
    EXPECT_EQ(completed({"demo", "--model", "="}), "full auto");
    EXPECT_EQ(completed({"demo", "--without", "gravity,vis"}), "gravity,viscous_friction");
    EXPECT_EQ(completed({"demo", "--seconds", ""}), "");
    EXPECT_EQ(completed({"device", "emu"}), "emulate");
    EXPECT_EQ(completed({"device", "emulate", "--clock", "w"}), "wall");
}

TEST(Completion, OffersFilesWhereTheyAreExpected) {
    const std::filesystem::path folder = testing::fresh_folder("completion_files");
    const std::string file = folder / "my.gltf";
    std::ofstream(file) << "{}";
    const std::string begun = folder / "my";
    EXPECT_EQ(completed({"demo", "--scene", begun}), file);
    EXPECT_EQ(completed({"demo", begun}), file);
    EXPECT_EQ(completed({"inspect", begun}), file);
    EXPECT_EQ(completed({"demo", "--servo-hz", begun}), "");
    EXPECT_EQ(completed({"stiffness", begun}), "");
}

} // namespace
} // namespace springdrive::app
