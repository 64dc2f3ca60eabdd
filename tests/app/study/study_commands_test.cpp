// Covers app/commands/study/study_{new,check,analyse,plan,pictures}.cpp, from outside:
// docs/study.md's walk with each shipped protocol, shortened; and what the study commands do with
// studies and protocols from people who mean harm, and who may read what they write.
#include "base/text.h"
#include "engine/study/store/study_store.h"
#include "tests/app/study/study_program.h"
#include "tests/engine/study/store/forged_study.h"
#include "tests/support/files.h"
#include "tests/support/names.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

namespace springdrive::app {
namespace {

namespace fs = std::filesystem;
using testing::ForgedStudy;
using testing::mode_of;
using testing::study;

TEST(StudyCommand, ListsTheIncludedProtocols) {
    const testing::Ending told = study({"new", "--list"});
    ASSERT_EQ(told.exit_status, 0) << told.error;
    for (const char *name : {"blow", "direction", "hardness", "mass", "stiffness"}) {
        EXPECT_NE(told.out.find(name), std::string::npos) << name;
    }
    EXPECT_NE(told.out.find("Force-direction discrimination"), std::string::npos);
}

TEST(StudyCommand, WritesAProtocolAndNeverOverAnother) {
    const fs::path file = testing::fresh_folder("study_new") / "mine.toml";
    const testing::Ending told = study({"new", "direction", "--out", file});
    ASSERT_EQ(told.exit_status, 0) << told.error;
    const std::string shipped =
        testing::contents_of(testing::assets() / "protocols/direction.toml");
    EXPECT_EQ(testing::contents_of(file), shipped) << "with its comments";
    testing::expect_refused(study({"new", "mass", "--out", file}), "mine.toml: exists");
    EXPECT_EQ(testing::contents_of(file), shipped);
    EXPECT_EQ(study({"new", "direction", "--out", "-"}).out, shipped);
}

TEST(StudyCommand, RefusesNamesThatAreNoProtocolInOneLine) {
    testing::expect_refused(study({"new", "directions"}),
                            "blow, can_you_feel_it, direction, hardness");
    testing::expect_refused(study({"new"}), "--list");
    testing::expect_refused(study({"check", "/nonexistent/p.toml"}), "p.toml");
}

TEST(StudyCommand, ChecksWhatItHasWritten) {
    const fs::path file = testing::fresh_folder("study_check") / "s.toml";
    ASSERT_EQ(study({"new", "stiffness", "--out", file}).exit_status, 0);
    const testing::Ending good = study({"check", file});
    EXPECT_EQ(good.exit_status, 0) << good.out << good.error;
    EXPECT_EQ(good.error, "");
    EXPECT_NE(good.out.find("session, with breaks"), std::string::npos) << good.out;
    EXPECT_NE(good.out.find("simulated"), std::string::npos) << good.out;

    std::string text = testing::contents_of(file);
    const std::string gain = "K_P_V_per_rad = 6.0";
    text.replace(text.find(gain), gain.size(), "K_P_V_per_rad = 90.0");
    std::ofstream(file) << text;
    const testing::Ending bad = study({"check", file});
    EXPECT_EQ(bad.exit_status, 1);
    EXPECT_NE(bad.out.find("error: condition \"light press\""), std::string::npos) << bad.out;
    EXPECT_NE(bad.out.find("is unstable"), std::string::npos) << bad.out;
    EXPECT_NE(bad.error.find("2 errors"), std::string::npos) << bad.error;

    text.replace(text.find("K_P_V_per_rad = 90.0"), 20, "K_P_V_per_rad = 900.0");
    std::ofstream(file) << text;
    testing::expect_refused(study({"check", file}),
                            "K_P_V_per_rad is 900; it must be a number from 0");
}

TEST(StudyCommand, FindsWhatKeepsPersonsOutBeforeAStudyBegins) {
    const fs::path folder = testing::fresh_folder("study_check_person");
    std::string text = testing::contents_of(testing::assets() / "protocols/blow.toml");
    const std::string keys = R"(keys = ["right", "left"])";
    ASSERT_NE(text.find(keys), std::string::npos);
    text.replace(text.find(keys), keys.size(), R"(keys = ["right", "two"])");
    const fs::path file = folder / "s.toml";
    std::ofstream(file) << text;
    const testing::Ending bad = study({"check", file, "--no-simulation"});
    EXPECT_EQ(bad.exit_status, 1);
    EXPECT_EQ(bad.out.find("error: with a person: responses.keys has \"two\""), 0U) << bad.out;
    testing::expect_refused(study({"run", file}), "with a person: responses.keys has \"two\"");
    EXPECT_FALSE(fs::exists(folder / "s.study"));
}

TEST(StudyCommand, RefusesAStudyInThePlaceOfItsProtocol) {
    const fs::path file = testing::fresh_folder("study_check_study") / "s.study";
    study::create_study(file, {"s", "title = \"s\"", "1.0"}, study::utc_now());
    for (const char *const command : {"check", "plan"}) {
        testing::expect_refused(study({command, file}), "s.study: is a study, no protocol; name");
    }
    testing::expect_refused(study({"run", file, "--study", "other.study"}), "is a study already");
    fs::copy_file(file, file.parent_path() / "s.toml");
    testing::expect_refused(study({"check", file.parent_path() / "s.toml"}), "is a study");
}

TEST(StudyCommand, LeavesTheSimulationOutIfAsked) {
    const testing::Ending told =
        study({"check", testing::assets() / "protocols/mass.toml", "--no-simulation"});
    EXPECT_EQ(told.exit_status, 0) << told.out << told.error;
    EXPECT_EQ(told.out.find("force N"), std::string::npos) << told.out;
}

void expect_picture(const fs::path &svg) {
    const std::string text = testing::contents_of(svg);
    EXPECT_NE(text.find("</svg>"), std::string::npos) << svg;
    EXPECT_EQ(text.find("nan"), std::string::npos) << svg;
}

double number(const std::string &text) { return std::stod(text); }

/// How many discs of a colour, as an RGB of SVG begins, are in a picture: one for each row that is
/// drawn, and one in the legend.
std::ptrdiff_t discs(const fs::path &svg, const std::string &colour) {
    const std::string text = testing::contents_of(svg);
    const std::regex disc("#gpPt6'[^>]*color='rgb\\(" + colour);
    return std::distance(std::sregex_iterator(text.begin(), text.end(), disc), {});
}

/// A protocol of which title and conditions have names of any characters: these, the title first.
std::vector<std::string> rename(std::string &protocol, unsigned seed) {
    std::mt19937_64 random(seed);
    std::vector<std::string> quoted;
    const std::regex name("(\ntitle|\\[\\[condition\\]\\]\nname) = (\"[^\"]*\")");
    for (std::sregex_iterator one(protocol.begin(), protocol.end(), name), end; one != end; ++one) {
        quoted.push_back(one->str(2));
    }
    std::vector<std::string> names;
    for (const std::string &old : quoted) {
        names.push_back(testing::random_name(random));
        const std::string typed = toml_string(names.back());
        for (std::size_t at = 0; (at = protocol.find(old, at)) != std::string::npos;
             at += typed.size()) {
            protocol.replace(at, old.size(), typed);
        }
    }
    return names;
}

class ShippedProtocol : public ::testing::TestWithParam<std::string> {};

TEST_P(ShippedProtocol, ComesFromNewToTheFigure) {
    const std::string name = GetParam();
    const fs::path folder = testing::fresh_folder("study_walk_" + name);
    const fs::path protocol = folder / (name + ".toml");
    ASSERT_EQ(study({"new", name, "--out", protocol}).exit_status, 0);
    std::string text = testing::shortened(name);
    const std::vector<std::string> names = rename(text, static_cast<unsigned>(name.size()));
    ASSERT_GE(names.size(), 3U);
    std::ofstream(protocol) << text;
    ASSERT_EQ(study({"check", protocol, "--no-simulation"}).exit_status, 0);
    std::vector<std::string> run{"run",       protocol, "--participants", "2",        "--observer",
                                 "simulated", "--felt", "once",           "--spread", "0.1"};
    const testing::Ending ran = study(run);
    ASSERT_EQ(ran.exit_status, 0) << ran.error;
    const fs::path file = folder / (name + ".study");
    ASSERT_EQ(study({"status", file}).exit_status, 0);

    testing::expect_refused(study({"analyse", file, "--out", folder / "results"}),
                            "on simulated devices (--device simulated)");
    const testing::Ending analysed =
        study({"analyse", file, "--device", "simulated", "--out", folder / "results"});
    ASSERT_EQ(analysed.exit_status, 0) << analysed.error;
    EXPECT_NE(analysed.out.find("no person's"), std::string::npos) << analysed.out;
    const std::string thresholds = testing::contents_of(folder / "results/thresholds.csv");
    const std::vector<std::string> medians = testing::column_of(thresholds, "threshold");
    const std::vector<std::string> lows = testing::column_of(thresholds, "threshold_low");
    const std::vector<std::string> highs = testing::column_of(thresholds, "threshold_high");
    ASSERT_GE(medians.size(), 4U) << "two participants, two conditions or more";
    for (std::size_t i = 0; i < medians.size(); ++i) {
        EXPECT_LT(number(lows[i]), number(medians[i]));
        EXPECT_LT(number(medians[i]), number(highs[i]));
    }
    expect_picture(folder / "results/functions_P01.svg");
    expect_picture(folder / "results/functions_P02.svg");
    expect_picture(folder / "results/group.svg");
    EXPECT_EQ(discs(folder / "results/group.svg", "119"), std::ssize(medians) + 1);
    const std::vector<std::string> levels =
        testing::column_of(testing::contents_of(folder / "results/levels.csv"), "participant");
    EXPECT_EQ(discs(folder / "results/functions_P01.svg", " *0"),
              std::ranges::count(levels, "P01") + 1);
    if (name != "hardness") { // constant stimuli have no course
        expect_picture(folder / "results/traces_P02.svg");
    }
    for (const auto &drawn : fs::directory_iterator(folder / "results")) {
        for (const std::string &each : names) {
            EXPECT_TRUE(drawn.path().extension() != ".svg" ||
                        testing::is_in_svg(testing::contents_of(drawn), each))
                << drawn.path().filename() << " lacks " << each;
        }
    }
    const std::vector<std::string> conditions = testing::column_of(thresholds, "condition");
    for (std::size_t i = 1; i < names.size(); ++i) {
        EXPECT_EQ(std::ranges::count(conditions, names[i]), 2) << names[i];
    }
    if (name != "stiffness") {
        return;
    }
    // What cannot be written is told before anything is.
    const fs::path blocked = folder / "blocked";
    fs::create_directories(blocked / "group.svg");
    const testing::Ending told =
        study({"analyse", file, "--device", "simulated", "--out", blocked});
    testing::expect_refused(told, "group.svg: is a folder");
    EXPECT_EQ(told.out, "");
    testing::expect_one_line(study({"analyse", file, "--device", "usb"}), 1,
                             "there are none on usb devices");
}

INSTANTIATE_TEST_SUITE_P(All, ShippedProtocol,
                         ::testing::Values("blow", "direction", "hardness", "mass", "stiffness"),
                         [](const auto &of) { return of.param; });

TEST(StudyPlan, TellsWhatAPrecisionTakes) {
    const fs::path folder = testing::fresh_folder("study_plan");
    const fs::path protocol = testing::assets() / "protocols/stiffness.toml";
    const testing::Ending told = study({"plan", protocol, "--trials", "10,21,80", "--studies", "40",
                                        "--precision", "3", "--out", folder / "plan"});
    ASSERT_EQ(told.exit_status, 0) << told.error;
    EXPECT_NE(told.out.find("a factor of 3 takes"), std::string::npos) << told.out;
    expect_picture(folder / "plan/precision.svg");
    const std::string csv = testing::contents_of(folder / "plan/precision.csv");
    EXPECT_EQ(testing::column_of(csv, "trials"), (std::vector<std::string>{"10", "21", "80"}));
    const std::vector<std::string> widths = testing::column_of(csv, "width_of_most");
    EXPECT_LT(number(widths[2]), number(widths[0])) << "more trials tell more";

    for (const char *const wrong : {"1.0", "1e308", "nan"}) {
        testing::expect_refused(study({"plan", protocol, "--precision", wrong}),
                                "it must be from 1.01 to 1000: a factor");
        testing::expect_refused(
            study({"plan", protocol, "--slope", wrong == std::string("1.0") ? "0" : wrong}),
            "slope is");
    }
    testing::expect_refused(study({"plan", protocol, "--trials", "0"}), "trials");
    const fs::path without = testing::without_expected("hardness", folder);
    testing::expect_refused(study({"plan", without}), "--threshold and --slope");
}

ForgedStudy forged(const std::string &name) {
    return {name, {"forged", testing::shortened("stiffness"), "1.0"}};
}

/// Each command that takes a study.
std::vector<std::vector<std::string>> commands_on(const fs::path &file) {
    const fs::path out = file.parent_path() / "h.out";
    return {{"note", file, "the room is warm"},
            {"status", file},
            {"export", file, "--csv", "-", "--device", "emulated"},
            {"export", file, "--bids", out, "--device", "emulated"},
            {"analyse", file, "--device", "emulated"},
            {"resume", file},
            {"run", file, "--participant", "P05", "--observer", "simulated"},
            {"remove", file, "P01"},
            {"remove", file, "P01", "--yes"}};
}

TEST(StudyHostile, IsRefusedByEachCommandInALine) {
    using Forge = void (*)(const ForgedStudy &);
    for (const Forge forge :
         {Forge([](const ForgedStudy &one) { one.forge_records_folder(".."); }),
          Forge([](const ForgedStudy &one) { one.forge_code("../beside/P01"); }),
          Forge([](const ForgedStudy &one) { one.forge_record("../beside/P01/kept"); }),
          Forge([](const ForgedStudy &one) { one.forge_journal(one.canary()); })}) {
        const ForgedStudy one = forged("hostile_commands");
        one.forge_removal();
        forge(one);
        for (const std::vector<std::string> &command : commands_on(one.file())) {
            testing::expect_refused(study(command), "h.study");
            EXPECT_TRUE(one.is_rest_untouched()) << command.front();
        }
        EXPECT_TRUE(fs::exists(one.records() / "P01"));
    }
}

/// A deletion that seems to have been interrupted, of records that may be somebody else's.
TEST(StudyHostile, RemovesRecordsOnlyWhenThatIsTyped) {
    const ForgedStudy one = forged("hostile_removal_command");
    one.forge_removal();
    const std::string text = "h.study: the deletion of P01 was interrupted; springdrive study "
                             "remove " +
                             one.file().string() + " P01 --yes completes it";
    for (const std::vector<std::string> &command : commands_on(one.file())) {
        if (command.back() == "--yes") {
            continue;
        }
        const testing::Ending ending = study(command);
        EXPECT_NE(ending.error.find(text), std::string::npos)
            << command.front() << ": " << ending.error;
        const bool goes_on = command.front() == "note" || command.front() == "status";
        EXPECT_EQ(ending.exit_status == 0, goes_on) << command.front();
        EXPECT_TRUE(fs::exists(one.records() / "P01")) << command.front();
    }
    fs::rename(one.records(), one.file().parent_path() / "h.kept");
    fs::create_directory_symlink("../beside", one.records());
    testing::expect_refused(study({"remove", one.file(), "P01", "--yes"}), "is a link");
    EXPECT_TRUE(one.is_rest_untouched());
    fs::remove(one.records());
    fs::rename(one.file().parent_path() / "h.kept", one.records());
    EXPECT_EQ(study({"remove", one.file(), "P01", "--yes"}).exit_status, 0);
    EXPECT_FALSE(fs::exists(one.records() / "P01"));
    EXPECT_TRUE(one.is_rest_untouched());
    EXPECT_EQ(study({"status", one.file()}).error, "");
}

TEST(StudyHostile, ProtocolsReadNothingOutsideOfTheirFolder) {
    const fs::path folder = testing::fresh_folder("hostile_protocol");
    fs::create_directory(folder / "in");
    fs::copy_file(testing::assets() / "devices/phantom_1_0.toml", folder / "mine.toml");
    fs::create_symlink("../mine.toml", folder / "in/link.toml");
    for (const std::string &name :
         {std::string("../mine.toml"), fs::absolute(folder / "mine.toml").string(),
          std::string("link.toml")}) {
        std::ofstream(folder / "in/a.toml") << std::regex_replace(
            testing::shortened("stiffness"), std::regex(R"(\ndevice = "phantom_1_0")"),
            "\ndevice = \"" + name + "\"");
        testing::expect_refused(study({"run", folder / "in/a.toml", "--participant", "P01",
                                       "--observer", "simulated", "--felt", "once"}),
                                "a.toml");
        EXPECT_FALSE(fs::exists(folder / "in/a.study"));
        const testing::Ending checked = study({"check", folder / "in/a.toml", "--no-simulation"});
        EXPECT_NE(checked.exit_status, 0);
        EXPECT_NE((checked.out + checked.error).find("protocol's "), std::string::npos)
            << checked.out << checked.error;
    }
}

TEST(StudyExports, AreTheirOwnersAlone) {
    const testing::Umask umask(0022);
    const ForgedStudy one = forged("export_modes");
    const fs::path folder = one.file().parent_path();
    const auto exported = [&](const std::string &force) {
        std::vector<std::string> typed{"export",   one.file(), "--device",
                                       "emulated", "--csv",    folder / "a.csv"};
        if (!force.empty()) {
            typed.push_back(force);
        }
        return study(typed);
    };
    ASSERT_EQ(exported("").exit_status, 0);
    EXPECT_EQ(mode_of(folder / "a.csv"), 0600U);
    // One that is there may be shared on purpose.
    fs::permissions(folder / "a.csv", fs::perms(0644));
    const testing::Ending again = exported("--force");
    EXPECT_EQ(again.exit_status, 0);
    EXPECT_NE(again.error.find("a.csv: others have rights to it (mode 644)"), std::string::npos);
    EXPECT_EQ(mode_of(folder / "a.csv"), 0644U);
}

TEST(StudyExports, OfSharedStudiesSayThatTheyAreShared) {
    const ForgedStudy one = forged("shared_study");
    EXPECT_EQ(study({"note", one.file(), "the room is warm"}).error, "");
    fs::permissions(one.file(), fs::perms(0640));
    fs::permissions(one.records(), fs::perms(0755));
    const testing::Ending ending = study({"note", one.file(), "the room is warm"});
    EXPECT_EQ(ending.exit_status, 0);
    EXPECT_NE(ending.error.find("h.study: others have rights to it (mode 640)"), std::string::npos)
        << ending.error;
    EXPECT_NE(ending.error.find("h.records: others have rights to it (mode 755)"),
              std::string::npos)
        << ending.error;
    EXPECT_EQ(mode_of(one.file()), 0640U);
}

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
