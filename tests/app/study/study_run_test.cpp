// Covers app/commands/study/study_run.cpp, study_turns.cpp and study_file_commands.cpp, from
// outside.
#include "app/commands/study/study_turns.h"
#include "engine/study/store/study_store.h"
#include "tests/app/study/study_program.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <fstream>
#include <regex>
#include <string>
#include <variant>
#include <vector>

namespace springdrive::app {
namespace {

namespace fs = std::filesystem;
using testing::study;

class StudyRun : public ::testing::Test {
protected:
    StudyRun() : folder_(testing::fresh_folder("study_run")) {}

    fs::path protocol(const std::string &name = "stiffness") {
        const fs::path file = folder_ / (name + ".toml");
        if (!fs::exists(file)) {
            std::ofstream(file) << testing::shortened(name);
        }
        return file;
    }
    [[nodiscard]] fs::path file(const std::string &name) const { return folder_ / name; }

    testing::Ending run(std::vector<std::string> options, int signal = 0,
                        const fs::path &started = {}) {
        options.insert(options.begin(), {"run", protocol().string()});
        options.insert(options.end(), {"--observer", "simulated", "--felt", "once"});
        return study(options, signal, started);
    }

    /// A copy of a study of three observers who are through, in place of what `run` would begin.
    [[nodiscard]] fs::path study_of_three() {
        static const fs::path original = [] {
            const fs::path folder = testing::fresh_folder("study_of_three");
            std::ofstream(folder / "stiffness.toml") << testing::shortened("stiffness");
            EXPECT_EQ(
                study({"run", folder / "stiffness.toml", "--observer", "simulated", "--felt",
                       "once", "--participants", "3", "--threshold", "0.05", "--spread", "0.3"})
                    .exit_status,
                0);
            return folder;
        }();
        for (const char *name : {"stiffness.toml", "stiffness.study"}) {
            fs::copy_file(original / name, file(name));
        }
        return file("stiffness.study");
    }

    /// All of each trial that is no time of day, what was delivered included: what a resumed study
    /// must repeat. Windings are warmed anew in each session.
    static std::string course_of(const fs::path &file) {
        const testing::Ending told = study({"export", file, "--csv", "-", "--device", "simulated"});
        EXPECT_EQ(told.exit_status, 0) << told.error;
        std::string course;
        std::vector<std::vector<std::string>> columns;
        for (const char *name :
             {"participant", "block", "position", "attempt", "condition", "level", "target",
              "response", "response_time_s", "presentation1_press_N_delivered",
              "presentation1_stiffness_N_per_m_delivered",
              "presentation2_stiffness_N_per_m_delivered", "marks"}) {
            columns.push_back(testing::column_of(told.out, name));
            if (columns.back().empty()) {
                ADD_FAILURE() << name;
                return name;
            }
        }
        for (std::size_t i = 0; i < columns.front().size(); ++i) {
            for (const std::vector<std::string> &column : columns) {
                course += column[i] + " ";
            }
            course += '\n';
        }
        return course;
    }

private:
    fs::path folder_;
};

TEST_F(StudyRun, BeginsAStudyAndGoesOnInIt) {
    const testing::Ending first = run({"--participant", "P01"});
    ASSERT_EQ(first.exit_status, 0) << first.error;
    EXPECT_NE(first.error.find("created: " + file("stiffness.study").string()), std::string::npos);
    EXPECT_NE(first.out.find("P01: session 1"), std::string::npos) << first.out;
    EXPECT_NE(first.out.find("completed"), std::string::npos) << first.out;
    const testing::Ending second = study({"run", file("stiffness.study"), "--participant", "AB7",
                                          "--observer", "simulated", "--felt", "once"});
    ASSERT_EQ(second.exit_status, 0) << second.error;
    EXPECT_EQ(second.error, "");

    const study::StudyContents contents = study::read_study(file("stiffness.study"));
    ASSERT_EQ(contents.participants.size(), 2U);
    EXPECT_EQ(contents.participants[1].code, "AB7");
    EXPECT_EQ(contents.participants[1].number, 2) << "given by itself";
    ASSERT_EQ(contents.sessions.size(), 2U);
    for (const study::Session &session : contents.sessions) {
        EXPECT_EQ(session.device, study::DeviceKind::simulated);
        EXPECT_EQ(session.ending, study::SessionEnding::completed);
    }
    EXPECT_EQ(contents.facts.protocol, testing::contents_of(protocol()));

    testing::expect_refused(run({"--participant", "P01"}), "P01 has done all");
    const testing::Ending nobody = run({"--participants", "1"});
    EXPECT_EQ(nobody.exit_status, 0) << nobody.error;
    EXPECT_EQ(nobody.out, file("stiffness.study").string() +
                              ": all 1 participants are through already; a larger --participants "
                              "adds some\n");
}

TEST_F(StudyRun, TellsWhereItStands) {
    const fs::path study_file = study_of_three();
    const std::size_t trials = study::read_study(study_file).trials.size();
    ASSERT_EQ(study({"note", study_file, "too warm here", "--participant", "P02"}).exit_status, 0);
    const testing::Ending told = study({"status", study_file});
    ASSERT_EQ(told.exit_status, 0) << told.error;
    for (const std::string &part :
         {std::string("P01"), std::string("P02"), std::string("through: 3 of 12"),
          "trials: " + std::to_string(trials), std::string("servo records: none"),
          std::string("questions: 0 answers: hand 0, sure 0, tiring 0, remarks 0; 3 sessions"),
          std::string("P02: too warm here")}) {
        EXPECT_NE(told.out.find(part), std::string::npos) << part << " in\n" << told.out;
    }
}

TEST_F(StudyRun, ExportsNobodysDataOnlyIfAskedTo) {
    const fs::path study_file = study_of_three();
    const std::size_t trials = study::read_study(study_file).trials.size();
    testing::expect_refused(study({"export", study_file, "--csv", file("t.csv")}),
                            "trials on simulated devices (--device simulated)");
    EXPECT_FALSE(fs::exists(file("t.csv")));
    testing::expect_refused(
        study({"export", study_file, "--answers", file("a.csv"), "--device", "simulated"}),
        "has no answers of sessions on simulated devices; they come from");
    EXPECT_FALSE(fs::exists(file("a.csv")));
    testing::expect_refused(study({"export", study_file}), "--csv FILE, --answers FILE, --bids");
    for (const char *const side : {"-lock", "-journal"}) { // not even by force
        testing::expect_refused(study({"export", study_file, "--csv", study_file.string() + side,
                                       "--device", "simulated", "--force"}),
                                "is also read");
    }

    ASSERT_EQ(study({"export", study_file, "--csv", file("t.csv"), "--bids", file("bids"),
                     "--device", "simulated", "--author", "Ada Lovelace", "--author", "J. Doe"})
                  .exit_status,
              0);
    EXPECT_NE(testing::contents_of(file("bids/dataset_description.json")).find("\"J. Doe\""),
              std::string::npos);
    testing::expect_refused(study({"export", study_file, "--csv", file("u.csv"), "--author", "J"}),
                            "--author");
    const std::string csv = testing::contents_of(file("t.csv"));
    EXPECT_EQ(testing::parsed_csv(csv).size(), 1 + trials);
    EXPECT_TRUE(fs::exists(file("bids/dataset_description.json")));
    testing::expect_refused(
        study({"export", study_file, "--csv", file("t.csv"), "--device", "simulated"}), "exists");
}

TEST_F(StudyRun, ResumedAfterStopAndKillGivesTheUndisturbedTrials) {
    // Long enough that it is still running when the signal comes.
    std::ofstream(file("stiffness.toml"))
        << testing::with(testing::contents_of(testing::assets() / "protocols/stiffness.toml"),
                         {{"_trials = 110", "_trials = 50"}});
    const fs::path whole = file("whole.study");
    ASSERT_EQ(run({"--participant", "P01", "--study", whole}).exit_status, 0);
    for (const int signal : {SIGTERM, SIGKILL}) {
        const fs::path broken = file(std::to_string(signal) + ".study");
        const testing::Ending ended =
            run({"--participant", "P01", "--study", broken}, signal, broken);
        ASSERT_LT(study::read_study(broken).trials.size(), study::read_study(whole).trials.size())
            << "it was to be interrupted";
        if (study::read_study(broken).participants.empty()) {
            ASSERT_EQ(run({"--participant", "P01", "--study", broken}).exit_status, 0);
        } else {
            const testing::Ending resumed = study({"resume", broken});
            ASSERT_EQ(resumed.exit_status, 0) << resumed.error;
        }
        EXPECT_EQ(course_of(broken), course_of(whole));
        const study::StudyContents contents = study::read_study(broken);
        if (signal == SIGTERM) {
            EXPECT_EQ(ended.exit_status, 0);
            EXPECT_NE(ended.error.find("study resume"), std::string::npos) << ended.error;
            EXPECT_EQ(contents.sessions.front().ending, study::SessionEnding::stopped);
        } else if (contents.sessions.size() > 1) {
            EXPECT_EQ(contents.sessions.front().ending, study::SessionEnding::interrupted);
        }
    }
}

TEST_F(StudyRun, GoesOnAfterAHangUpThatNohupIgnores) {
    std::ofstream(file("stiffness.toml"))
        << testing::with(testing::contents_of(testing::assets() / "protocols/stiffness.toml"),
                         {{"_trials = 110", "_trials = 50"}});
    for (const bool is_ignored : {true, false}) {
        const fs::path study_file = file(is_ignored ? "nohup.study" : "hung_up.study");
        const auto before = std::signal(SIGHUP, is_ignored ? SIG_IGN : SIG_DFL);
        const testing::Ending ending =
            run({"--participant", "P01", "--study", study_file}, SIGHUP, study_file);
        std::signal(SIGHUP, before);
        EXPECT_EQ(ending.exit_status, is_ignored ? 0 : ending.exit_status) << ending.error;
        const study::StudyContents contents = study::read_study(study_file);
        const bool is_completed = !contents.sessions.empty() && contents.sessions.front().ending ==
                                                                    study::SessionEnding::completed;
        EXPECT_EQ(is_completed, is_ignored);
    }
}

TEST_F(StudyRun, RefusesInOneLineAndLosesNothing) {
    const fs::path study_file = file("stiffness.study");
    testing::expect_refused(study({"run", protocol(), "--participants", "3"}),
                            "persons come one at a time");
    testing::expect_refused(run({}), "--participant P01");
    testing::expect_refused(run({"--participant", "Anna"}), "is no participant's code");
    EXPECT_FALSE(fs::exists(study_file)) << "nothing is created before that";
    fs::remove(protocol());
    static_cast<void>(study_of_three());
    const std::string before = testing::contents_of(study_file);

    testing::expect_refused(study({"resume", study_file, "--participant", "P09"}),
                            "no participant P09");
    testing::expect_refused(study({"note", study_file, "x", "--participant", "P09"}),
                            "stiffness.study: has no participant 'P09'; springdrive study status");
    testing::expect_refused(study({"note", study_file, " "}), "no text");
    testing::expect_refused(run({"--participant", "P09", "--seed", "-1"}), "--seed");
    testing::expect_refused(study({"remove", study_file, "P09"}),
                            "stiffness.study: has no participant 'P09'; springdrive study status");
    testing::expect_refused(study({"remove", study_file, "P01"}), "add --yes");
    testing::expect_refused(study({"status", protocol()}), "stiffness.toml");
    testing::expect_refused(study({"status", file("none.study")}), "none.study");
    {
        const study::StudyStore open(study_file); // nobody is waited for
        testing::expect_refused(run({"--participant", "P09"}), "stiffness.study");
        EXPECT_EQ(study({"status", study_file}).exit_status, 0) << "readers never wait";
    }

    std::ofstream(protocol(), std::ios::app) << "# a comment\n";
    testing::expect_refused(run({"--participant", "P09"}), "begun with another protocol");
    EXPECT_EQ(testing::contents_of(study_file), before);
}

/// Whoever sits down must not go on with another one's session.
TEST_F(StudyRun, ResumesNobodyWhereTwoPersonsAreInTheMidstOfIt) {
    const fs::path study_file = file("two.study");
    study::create_study(study_file, {"Two", testing::contents_of(protocol()), "0.1.0"},
                        study::utc_now());
    for (const int number : {1, 2}) {
        study::StudyStore store(study_file);
        study::Session session;
        session.participant = "P0" + std::to_string(number);
        session.started = study::utc_now();
        session.software = "0.1.0";
        store.add({session.participant, number, session.started});
        static_cast<void>(store.begin(session)); // and is never ended
    }
    const testing::Ending refused = study({"resume", study_file});
    testing::expect_refused(refused, "P01, P02 are in the midst of it; say with --participant");
    EXPECT_EQ(study::read_study(study_file).sessions.size(), 2U) << "none was begun";
    testing::expect_refused(study({"resume", study_file, "--participant", "P03"}),
                            "no participant P03");
}

TEST_F(StudyRun, GoesOnWhenAFullDiskHasSpaceAgain) {
    const fs::path whole = file("whole.study");
    const fs::path study_file = file("full.study");
    ASSERT_EQ(run({"--participant", "P01", "--study", study_file}).exit_status, 0);
    fs::copy_file(study_file, whole);
    ASSERT_EQ(run({"--participant", "P02", "--study", whole}).exit_status, 0);
    const std::size_t before = study::read_study(study_file).trials.size();
    {
        const testing::FullDisk disk(fs::file_size(study_file) + 4096); // a few trials more
        const testing::Ending ending = run({"--participant", "P02", "--study", study_file});
        EXPECT_EQ(ending.exit_status, 1) << ending.out;
        EXPECT_NE(ending.error.find("full.study"), std::string::npos) << ending.error;
        EXPECT_EQ(std::ranges::count(ending.error, '\n'), 1) << ending.error;
    }
    EXPECT_GE(study::read_study(study_file).trials.size(), before);
    EXPECT_LT(study::read_study(study_file).trials.size(), study::read_study(whole).trials.size());
    ASSERT_EQ(run({"--participant", "P02", "--study", study_file}).exit_status, 0);
    EXPECT_EQ(course_of(study_file), course_of(whole));
}

/// The code is not given again: lists on paper and older exports still have it.
TEST_F(StudyRun, RemovesAParticipantOnRequest) {
    const fs::path study_file = study_of_three();
    const auto next_code = [&] { return StudyTurns(study_file, {}).next_code(); };
    EXPECT_EQ(next_code(), "P04");
    ASSERT_EQ(study({"note", study_file, "P01 and P02 met"}).exit_status, 0);
    const testing::Ending removed = study({"remove", study_file, "P01", "--yes"});
    ASSERT_EQ(removed.exit_status, 0);
    EXPECT_NE(removed.error.find("the code was replaced in 1 text of others or of the study"),
              std::string::npos)
        << removed.error;
    EXPECT_EQ(testing::contents_of(study_file).find("P01"), std::string::npos);
    const study::StudyContents contents = study::read_study(study_file);
    ASSERT_EQ(contents.participants.size(), 2U);
    EXPECT_EQ(contents.participants.front().code, "P02");
    EXPECT_EQ(contents.facts.removed_participants, 1);
    EXPECT_NE(study({"status", study_file}).out.find("1 removed on request"), std::string::npos);
    for (const char *code : {"P03", "P02"}) {
        ASSERT_EQ(study({"remove", study_file, code, "--yes"}).exit_status, 0);
        EXPECT_EQ(next_code(), "P04") << code;
    }
}

TEST_F(StudyRun, CreatesNoStudyThatWouldNotFindItsDevice) {
    fs::copy_file(testing::assets() / "devices/phantom_1_0.toml", file("mine.toml"));
    std::string text = testing::shortened("stiffness");
    text = std::regex_replace(text, std::regex(R"(\ndevice = "phantom_1_0")"),
                              "\ndevice = \"mine.toml\"");
    ASSERT_NE(text.find("mine.toml"), std::string::npos);
    std::ofstream(file("own.toml")) << text;
    fs::create_directory(file("elsewhere"));
    const std::vector<std::string> typed{
        "run",       file("own.toml"), "--participant", "P01",     "--observer",
        "simulated", "--threshold",    "0.1",           "--slope", "2",
        "--study"};
    std::vector<std::string> elsewhere = typed;
    elsewhere.push_back(file("elsewhere/own.study"));
    testing::expect_refused(study(elsewhere), "has to be beside the study");
    EXPECT_FALSE(fs::exists(file("elsewhere/own.study")));
    std::vector<std::string> beside = typed;
    beside.push_back(file("other_name.study"));
    EXPECT_EQ(study(beside).exit_status, 0);
}

TEST_F(StudyRun, DrawsObserversAsTypedAndRemembersThem) {
    const study::StudyContents contents = study::read_study(study_of_three());
    std::vector<double> thresholds;
    for (const study::Session &session : contents.sessions) {
        for (const study::Setting &fact : session.facts) {
            if (fact.name == "observer_threshold") {
                thresholds.push_back(std::get<double>(fact.value));
            }
        }
    }
    ASSERT_EQ(thresholds.size(), 3U);
    EXPECT_NE(thresholds[0], thresholds[1]);
    EXPECT_NE(thresholds[1], thresholds[2]);
    for (const double threshold : thresholds) {
        EXPECT_GT(threshold, 0.05 * std::exp(-4.0 * 0.3)); // 4 standard deviations
        EXPECT_LT(threshold, 0.05 * std::exp(4.0 * 0.3));
    }
    testing::expect_refused(study({"run", testing::without_expected("hardness", file("")),
                                   "--participant", "P01", "--observer", "simulated"}),
                            "--threshold and --slope");
    testing::expect_refused(
        run({"--participants", "4", "--lapse", "2", "--study", file("other.study")}), "lapse");
    EXPECT_FALSE(fs::exists(file("other.study")));
}

} // namespace
} // namespace springdrive::app
