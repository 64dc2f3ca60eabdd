// Covers what engine/study/store does with studies from people who mean harm.
#include "tests/engine/study/store/forged_study.h"
#include "tests/support/error_text.h"
#include "tests/support/modes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

namespace springdrive::study {
namespace {

using namespace std::string_literals;
using testing::contents_of;
using testing::error_text_of;
using testing::ForgedStudy;
using testing::mode_of;
using testing::said_on_opening;
using testing::said_on_reading;

/// Reading and opening for writing say one line, which has `part`; nothing else is touched.
void expect_refused(const ForgedStudy &study, const std::string &part, const std::string &what) {
    for (const std::string &said : {said_on_reading(study.file()), said_on_opening(study.file())}) {
        EXPECT_NE(said.find(part), std::string::npos) << what << ": " << said;
        EXPECT_TRUE(
            std::ranges::none_of(said, [](char c) { return static_cast<unsigned char>(c) < 0x20; }))
            << what << ": " << said;
    }
    EXPECT_TRUE(study.is_rest_untouched()) << what;
}

TEST(HostileStudy, LeadsToNoFolderOfRecordsButItsOwn) {
    const std::string absolute =
        std::filesystem::absolute(testing::fresh_folder("hostile_absolute")).string();
    for (const std::string &name :
         {".."s, "."s, ""s, "/"s, absolute, "../beside"s, "in"s, "P01"s, "../beside.records"s,
          "a/../../beside.records"s, absolute + "/x.records", "x\n.records"s, "x\0.records"s,
          std::string(300, 'x') + ".records"}) {
        const ForgedStudy study("hostile_folder", testing::sample_new_study());
        study.forge_records_folder(name);
        study.forge_record((std::filesystem::path(name) / "P01/a.rec").string());
        study.forge_removal();
        expect_refused(study, ": is damaged (", name);
        EXPECT_NE(error_text_of([&] { StudyStore(study.file()).remove_participant("P01"); }), "");
        EXPECT_TRUE(study.is_rest_untouched()) << name;
    }
}

TEST(HostileStudy, HasNoParticipantsButCodes) {
    for (const std::string &code : {"../P01"s, ".."s, "."s, ""s, "P01/.."s, "P01\0"s, "P01\n"s,
                                    "/tmp"s, "../../beside/P01"s, std::string(300, 'P') + "1"}) {
        const ForgedStudy study("hostile_code", testing::sample_new_study());
        study.forge_code(code);
        expect_refused(study, ": is damaged (", code);
    }
}

TEST(HostileStudy, LinksNoRecordsButThoseOfItsTrials) {
    for (const std::string &path :
         {"/etc/passwd"s, "../beside/P01/kept"s, "h.records/P01/../../P01/kept"s,
          "h.records/P02/a.rec"s, "h.records/P01/a\0.rec"s, "h.records/P01/a\nb"s,
          "h.records/P01/" + std::string(300, 'x')}) {
        const ForgedStudy study("hostile_record", testing::sample_new_study());
        study.forge_record(path);
        expect_refused(study, ": is damaged (", path);
    }
}

/// What a link leads to is not even read.
TEST(HostileStudy, ReadsNoRecordsByWayOfALink) {
    const ForgedStudy study("hostile_link", testing::sample_new_study());
    const std::filesystem::path record = study.records() / "P01/block1-position001-attempt1.rec";
    const auto problems = [&] { return validate_records(study.file(), read_study(study.file())); };
    ASSERT_TRUE(std::filesystem::exists(record));
    EXPECT_EQ(problems(), std::vector<std::string>{});
    std::filesystem::remove(record);
    std::filesystem::create_symlink(study.canary(), record);
    ASSERT_EQ(problems().size(), 1U);
    EXPECT_NE(problems().front().find("is a link"), std::string::npos) << problems().front();
}

/// Only who requests a deletion gets one, whatever the study says of itself.
TEST(HostileStudy, RemovesNothingUnrequested) {
    const ForgedStudy study("hostile_removal", testing::sample_new_study());
    study.forge_removal();
    study.forge_records_folder("other.records");
    study.forge_record("other.records/P01/kept");
    {
        StudyStore store(study.file());
        store.append(Note{testing::kStart, "note", "the room is warm", {}, {}});
        EXPECT_EQ(store.contents().unfinished_removals, std::vector<std::string>{"P01"});
        EXPECT_TRUE(store.contents().trials.empty());
    }
    EXPECT_EQ(read_study(study.file()).unfinished_removals, std::vector<std::string>{"P01"});
    EXPECT_TRUE(study.is_rest_untouched());
}

/// SQLite deletes the file that a journal names, even for a reader.
TEST(HostileStudy, HasAJournalThatNamesAnotherFile) {
    const ForgedStudy study("hostile_journal", testing::sample_new_study());
    study.forge_journal(study.canary());
    expect_refused(study, "h.study-journal: names another file", "journal");
}

/// The lock is written to, and so are journals.
TEST(HostileStudy, HasALinkForALockOrJournal) {
    using Link = std::function<void(const std::filesystem::path &, const std::filesystem::path &)>;
    const Link symbolic = [](const auto &to, const auto &name) {
        std::filesystem::create_symlink(to, name);
    };
    const Link hard = [](const auto &to, const auto &name) {
        std::filesystem::create_hard_link(to, name);
    };
    for (const Link &link : {symbolic, hard}) {
        for (const char *const ending : {"-lock", "-journal", "-wal", "-shm"}) {
            const ForgedStudy study("hostile_beside", testing::sample_new_study());
            const std::string name = study.file().string() + ending;
            link(study.canary(), name);
            EXPECT_EQ(said_on_opening(study.file()).find(name + ": is a link or no ordinary"), 0U);
            static_cast<void>(said_on_reading(study.file())); // which needs no lock
            EXPECT_TRUE(study.is_rest_untouched()) << name;
        }
    }
    // Nor is a lock made through a link to nothing.
    const ForgedStudy study("hostile_new", testing::sample_new_study());
    symbolic("../beside/new", study.file().string() + "-lock");
    EXPECT_NE(said_on_opening(study.file()), "");
    EXPECT_TRUE(study.is_rest_untouched());
}

TEST(StudyModes, AreTheOwnersAloneUnderEachUmask) {
    for (const mode_t mask : {0000U, 0022U, 0077U}) {
        const testing::Umask umask(mask);
        const ForgedStudy study("study_modes", testing::sample_new_study());
        StudyStore store(study.file());
        EXPECT_EQ(mode_of(study.file()), 0600U);
        EXPECT_EQ(mode_of(study.file().string() + "-lock"), 0600U);
        EXPECT_EQ(mode_of(study.records()), 0700U);
        EXPECT_EQ(mode_of(study.records() / "P01"), 0700U);
        store.append(Note{testing::kStart, "note", "a", {}, {}});
        const Database database(study.file(), study.file(), Access::write, {});
        Transaction transaction(database, Transaction::Kind::write);
        database.run("UPDATE note SET text = 'b'");
        database.run("PRAGMA cache_spill = 1");
        EXPECT_EQ(mode_of(study.file().string() + "-journal"), 0600U);
    }
}

/// Somebody may have shared it on purpose.
TEST(StudyModes, OfAStudyThatIsThereStay) {
    const testing::Umask umask(0022);
    const ForgedStudy study("study_modes_kept", testing::sample_new_study());
    std::filesystem::permissions(study.file(), std::filesystem::perms(0640));
    std::filesystem::permissions(study.records(), std::filesystem::perms(0750));
    StudyStore store(study.file());
    store.append(Note{testing::kStart, "note", "a", {}, {}});
    store.add({"P02", 2, testing::kStart});
    static_cast<void>(store.new_record_file("P02", {}));
    EXPECT_EQ(mode_of(study.file()), 0640U);
    EXPECT_EQ(mode_of(study.records()), 0750U);
    EXPECT_EQ(mode_of(study.records() / "P02"), 0700U) << "what is new";
}

TEST(StudyModes, NoStudyHasANameThatItsRecordsCouldNotHave) {
    const auto folder = testing::fresh_folder("study_names");
    for (const std::string &name : {"a\nb.study"s, std::string(250, 'a') + ".study"}) {
        EXPECT_NE(error_text_of([&] {
                      create_study(folder / name, testing::sample_new_study(), testing::kStart);
                  }),
                  "");
    }
    EXPECT_TRUE(std::filesystem::is_empty(folder));
}

} // namespace
} // namespace springdrive::study
