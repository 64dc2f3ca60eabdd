// Covers app/visitors/visitor_window.cpp and app/commands/study/study_try.cpp: "Can you feel it?"
// in the real window, with a visitor at mouse and keyboard.
#include "tests/support/devices.h"
#include "tests/support/files.h"
#include "tests/support/shown_window.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <string>
#include <thread>
#include <vector>

namespace springdrive::app {
namespace {

namespace fs = std::filesystem;
using testing::Report;

/// The shipped protocol with two trials and no practice.
fs::path short_protocol(const fs::path &folder) {
    std::string text =
        testing::contents_of(testing::assets() / "protocols" / "can_you_feel_it.toml");
    for (const auto &[pattern, replacement] : {std::pair{"\nfewest_trials = 34\nmost_trials = 34",
                                                         "\nfewest_trials = 2\nmost_trials = 2"},
                                               std::pair{"\nfewest_trials = 3\nmost_trials = 3",
                                                         "\nfewest_trials = 0\nmost_trials = 0"}}) {
        EXPECT_NE(text.find(pattern), std::string::npos);
        text = std::regex_replace(text, std::regex(pattern), replacement);
    }
    const fs::path file = folder / "short.toml";
    std::ofstream(file) << text;
    return file;
}

/// Files that this test has open, from whoever started it (CTest, say): a program inherits them.
std::set<fs::path> inherited_files() {
    std::set<fs::path> files;
    for (const fs::directory_entry &entry : fs::directory_iterator("/proc/self/fd")) {
        std::error_code gone;
        files.insert(fs::read_symlink(entry.path(), gone));
    }
    return files;
}

/// Regular files that a process has open for writing, apart from its standard error and from what
/// it inherited.
std::vector<std::string> written_files(pid_t process) {
    const fs::path proc = "/proc/" + std::to_string(process);
    const fs::path error = fs::read_symlink(proc / "fd/2");
    const std::set<fs::path> inherited = inherited_files();
    std::vector<std::string> files;
    for (const fs::directory_entry &entry : fs::directory_iterator(proc / "fd")) {
        std::error_code gone;
        const fs::path target = fs::read_symlink(entry.path(), gone);
        const std::string number = entry.path().filename();
        if (gone || target == error || inherited.contains(target) ||
            !fs::is_regular_file(target, gone)) {
            continue;
        }
        const std::string info = testing::contents_of(proc / "fdinfo" / number);
        const std::size_t flags = info.find("flags:");
        const unsigned long mode = std::stoul(info.substr(flags + 6), nullptr, 8);
        if ((mode & 3UL) != 0) { // not O_RDONLY
            files.push_back(target);
        }
    }
    return files;
}

std::vector<fs::path> names_in(const fs::path &folder) {
    std::vector<fs::path> names;
    for (const fs::directory_entry &entry : fs::recursive_directory_iterator(folder)) {
        names.push_back(entry.path());
    }
    std::ranges::sort(names);
    return names;
}

class VisitorsInTheWindow : public ::testing::Test {
protected:
    VisitorsInTheWindow()
        : folder_(testing::fresh_folder("visitors")), protocol_(short_protocol(folder_)),
          display_(1280, 720),
          program_(display_, {"study", "try", protocol_.string(), "--report"}, folder_),
          person_(display_) {
        wait_for("Can you feel it?"); // by then there is one window only
        person_.wait_for_window();
    }

    Report look() {
        program_.send_line("report");
        const auto line = program_.read_line(std::chrono::seconds(60));
        if (!line) {
            throw std::runtime_error("the window does not report: " + program_.error());
        }
        return Report(nlohmann::json::parse(*line));
    }

    Report wait_for(const std::string &text, double limit_s = 40.0) {
        const auto start = std::chrono::steady_clock::now();
        for (;;) {
            Report report = look();
            if (report.shows(text)) {
                return report;
            }
            if (std::chrono::steady_clock::now() - start > std::chrono::duration<double>(limit_s)) {
                ADD_FAILURE() << "not shown: " << text << "; but\n" << report.texts();
                return report;
            }
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
        }
    }

    void click_choice(int number) {
        const Report report = look();
        const nlohmann::json &item = report.item("visitor/choice " + std::to_string(number));
        person_.click(item.at("x").get<float>() + 0.5F * item.at("width").get<float>(),
                      item.at("y").get<float>() + 0.5F * item.at("height").get<float>());
    }

    fs::path folder_;
    fs::path protocol_;
    testing::VirtualDisplay display_;
    testing::RunningProgram program_;
    testing::Person person_;
};

TEST_F(VisitorsInTheWindow, FromTheStartToTheCurveAndToTheNextOneWithoutAFile) {
    const std::vector<fs::path> before = names_in(folder_);
    const Report start = wait_for("Can you feel it?");
    EXPECT_EQ(start.all().at("window").at("width"), 1280.0); // it fills the screen
    EXPECT_EQ(start.all().at("window").at("height"), 720.0);
    EXPECT_TRUE(start.shows("Nothing of this is kept"));
    click_choice(2); // "Guess"
    wait_for("Hold the pen");
    click_choice(1); // "Go on"
    for (int trial = 0; trial < 2; ++trial) {
        wait_for("Press 1 or 2.");
        EXPECT_EQ(written_files(program_.process()), std::vector<std::string>{});
        if (trial == 0) {
            click_choice(1);
            wait_for("Hold still"); // above the mark: the next one
        } else {
            person_.key("2");
        }
    }
    const Report curve = wait_for("These were guesses");
    EXPECT_FALSE(curve.item("visitor/curve").at("text").get<std::string>().empty());
    EXPECT_EQ(written_files(program_.process()), std::vector<std::string>{});
    EXPECT_EQ(names_in(folder_), before);
    person_.key("Return");
    wait_for("Can you feel it?");
    person_.key("ctrl+alt+q");
    const testing::Ending ending = program_.end(0);
    EXPECT_EQ(ending.exit_status, 0) << ending.error;
    EXPECT_NE(ending.error.find("1 visit begun; nothing of them was stored"), std::string::npos)
        << ending.error;
    EXPECT_EQ(names_in(folder_), before);
}

} // namespace
} // namespace springdrive::app
