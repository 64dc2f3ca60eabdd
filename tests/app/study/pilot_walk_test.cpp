// Covers docs/pilot_walk.md: its edit applies, its commands run in their order, what is printed
// before the first session is what the page says, and its pictures and files exist. Sessions in the
// windows are held by simulated observers here; tests/pilot_walk holds them in the windows.
#include "tests/app/study/study_program.h"

#include "engine/study/store/study_store.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

namespace springdrive::app {
namespace {

namespace fs = std::filesystem;

/// A command of the page, and the lines of the block that follows it before the next command.
struct Step {
    std::vector<std::string> words; ///< without "springdrive"
    std::vector<std::string> printed;
};

struct Page {
    std::string diff;
    std::vector<Step> steps;
    std::vector<std::string> pictures; ///< relative to docs
};

fs::path docs() { return testing::assets().parent_path() / "docs"; }

std::vector<std::string> words_of(const std::string &line) {
    std::vector<std::string> words;
    const std::regex word(R"re("([^"]*)"|(\S+))re");
    for (std::sregex_iterator at(line.begin(), line.end(), word), end; at != end; ++at) {
        words.push_back((*at)[1].matched ? (*at)[1].str() : (*at)[2].str());
    }
    return words;
}

Page read_page() {
    Page page;
    std::istringstream lines(testing::contents_of(docs() / "pilot_walk.md"));
    bool is_diff = false;
    const std::regex picture(R"(!\[[^\]]*\]\(([^)]*)\))");
    for (std::string line; std::getline(lines, line);) {
        std::smatch match;
        if (line.starts_with("```")) {
            is_diff = line == "```diff";
        } else if (is_diff) {
            page.diff += line + '\n';
        } else if (line.starts_with("    springdrive ")) {
            std::vector<std::string> words = words_of(line);
            words.erase(words.begin());
            page.steps.push_back({words, {}});
        } else if (line.starts_with("    ") && !page.steps.empty()) {
            page.steps.back().printed.push_back(line.substr(4));
        } else if (std::regex_search(line, match, picture)) {
            page.pictures.push_back(match[1]);
        }
    }
    return page;
}

bool is_session(const Step &step) {
    return step.words.at(1) == "run" && std::ranges::count(step.words, "--observer") == 0;
}

class PilotWalk : public ::testing::Test {
protected:
    PilotWalk() : before_(fs::current_path()) {
        fs::current_path(testing::fresh_folder("pilot_walk"));
    }
    ~PilotWalk() override { fs::current_path(before_); }

private:
    fs::path before_;
};

TEST_F(PilotWalk, RunsAsItIsWritten) {
    const Page page = read_page();
    ASSERT_GE(page.steps.size(), 14U);
    ASSERT_FALSE(page.diff.empty());
    int sessions = 0;
    bool is_before_sessions = true;
    for (const Step &step : page.steps) {
        std::string typed = "springdrive";
        for (const std::string &word : step.words) {
            typed += " " + word;
        }
        SCOPED_TRACE(typed);
        std::vector<std::string> words = step.words;
        if (is_session(step)) {
            is_before_sessions = false;
            words.insert(words.end(), {"--participant", "P0" + std::to_string(++sessions),
                                       "--observer", "simulated", "--felt", "once"});
        } else if (words.at(1) == "resume") { // of those who are not through: here it is nobody
            std::erase(words, "--participant");
            std::erase(words, "P03");
        } else if (words.at(1) == "export") { // observers answer no questions
            std::erase(words, "--answers");
            std::erase(words, "answers.csv");
        }
        const testing::Ending ending = testing::run_program(words);
        ASSERT_EQ(ending.exit_status, 0) << ending.error;
        for (const std::string &line : step.printed) {
            if (is_before_sessions) {
                EXPECT_NE((ending.out + ending.error).find(line), std::string::npos)
                    << line << "\nis not in\n"
                    << ending.out;
            }
        }
        if (words.at(1) == "new") {
            std::ofstream("cut.diff") << page.diff;
            ASSERT_EQ(std::system("patch --silent pilot.toml cut.diff"), 0);
        }
    }
    EXPECT_EQ(sessions, 5);
    EXPECT_EQ(study::read_study("pilot.study").participants.size(), 5U);
    for (const char *file : {"plan/precision.svg", "trial-results/group.svg", "results/group.svg",
                             "results/functions_P01.svg", "trials.csv", "bids"}) {
        EXPECT_TRUE(fs::exists(file)) << file;
    }
    EXPECT_FALSE(page.pictures.empty());
    for (const std::string &picture : page.pictures) {
        EXPECT_TRUE(fs::exists(docs() / picture)) << picture;
    }
}

} // namespace
} // namespace springdrive::app
