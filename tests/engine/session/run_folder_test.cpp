// Covers engine/session/run_folder.cpp, and write_record of record.cpp.
#include "engine/session/run_folder.h"

#include "base/input_error.h"
#include "engine/control/tuning_file.h"
#include "engine/record/record_file.h"
#include "engine/session/telemetry_history.h"
#include "tests/engine/record/samples.h"
#include "tests/support/devices.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <ctime>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <sys/mount.h>
#include <utility>
#include <vector>

namespace springdrive::session {
namespace {

using testing::contents_of;
using testing::fresh_folder;
using testing::FullDisk;

std::set<std::string> names_in(const std::filesystem::path &folder) {
    std::set<std::string> names;
    for (const auto &entry : std::filesystem::directory_iterator(folder)) {
        names.insert(entry.path().filename());
    }
    return names;
}

/// With a 0 for every digit.
std::string without_digits(const std::filesystem::path &folder) {
    std::string name = folder.filename();
    std::ranges::replace_if(
        name, [](char c) { return c >= '0' && c <= '9'; }, '0');
    return name;
}

/// Text that breaks careless formats.
const std::string kHardText = "a \"quoted\" name,\nof two lines;\r\n Ω → ü\t'%s' {} \\ \xff end";

control::Tuning hard_tuning(double K_P_V_per_rad) {
    control::Tuning tuning;
    tuning.K_P_V_per_rad = K_P_V_per_rad;
    tuning.dR_Ohm = 1.0 / 3.0;
    tuning.map = control::MotionMap::inverse;
    tuning.alpha_mode = control::AlphaMode::by_hand;
    return tuning;
}

RunFacts some_facts() {
    using namespace std::chrono_literals;
    RunFacts facts;
    facts.software = "0.1.0";
    facts.started = std::chrono::sys_days(std::chrono::year(2024) / 5 / 31) + 12h + 34min + 56s;
    facts.kept = facts.started + 100s;
    facts.until_s = 0.1 + 0.2;
    facts.servo_hz = 4000.0;
    facts.delay_periods = 0.7;
    facts.devices.push_back(
        {"PHANTOM", "a/b.toml", "first = 1\n", 7, simulated::PlantEffects::none(), false});
    constexpr std::uint64_t kSeed = 18'446'744'073'709'551'557U; // as a double ...552
    facts.devices.push_back({"another", "c.toml", "second = 2\n", kSeed, {}, true});
    facts.scene = {"/scenes/plate.gltf", "0123abcd", 12};
    facts.slots = TuningSlots(hard_tuning(1.0));
    facts.slots.toggle();
    facts.slots.set(hard_tuning(2.0));
    facts.journal = {{0.0, 0.0, "start", hard_tuning(1.0)},
                     {1.0, 1.0 + 1e-15, kHardText, hard_tuning(0.1)},
                     {1.5, 2.5, "", hard_tuning(499.99999999999994)}};
    facts.events = {{0.5, kHardText}, {0.75, ""}};
    facts.notes = kHardText;
    facts.records = {{"past.rec", -1.0 / 3.0, 0}, {"/elsewhere/touch.rec", 5.0, 1}};
    facts.screenshots = {"screenshot-1.png", "screenshot-2.png"};
    return facts;
}

/// run.json of `some_facts`, without its line ends and blanks.
const std::string kRunJson =
    R"({"format":"springdriverun1","software":"0.1.0","started_utc":"2024-05-31T12:34:56Z",)"
    R"("kept_utc":"2024-05-31T12:36:36Z","until_s":0.30000000000000004,"servo_hz":4000.0,)"
    R"("delay_periods":0.7,"devices":[{"toml":"device.toml","name":"PHANTOM","file":"a/b.toml",)"
    R"("seed":"7","effects":{"gravity":false,"viscous_friction":false,"coulomb_friction":false,)"
    R"("joint_limits":false,"amplifier_limits":false,"winding_heat":false,)"
    R"("commutation_ripple":false,"structural_compliance":false,"cable_compliance":false,)"
    R"("magnet_heat":false,)"
    R"("motor_tolerances":false,"commutator_phase":false,"current_sensing":false,)"
    R"("brush_voltage":false,"torque_ripple":false},"observes_resistance":false},)"
    R"({"toml":"device-2.toml","name":"another","file":"c.toml",)"
    R"("seed":"18446744073709551557","effects":{"gravity":true,"viscous_friction":true,"coulomb_friction":true,)"
    R"("joint_limits":true,"amplifier_limits":true,"winding_heat":true,)"
    R"("commutation_ripple":true,"structural_compliance":false,"cable_compliance":false,)"
    R"("magnet_heat":true,)"
    R"("motor_tolerances":true,"commutator_phase":true,"current_sensing":true,)"
    R"("brush_voltage":true,"torque_ripple":true},"observes_resistance":true}],)"
    R"("scene":{"file":"/scenes/plate.gltf","sha256":"0123abcd","triangles":12},)"
    R"("active_slot":"B","records":[)"
    R"({"file":"past.rec","start_s":-0.3333333333333333,"device":"device.toml"},)"
    R"({"file":"/elsewhere/touch.rec","start_s":5.0,"device":"device-2.toml"}],)"
    R"("screenshots":["screenshot-1.png","screenshot-2.png"]})";

/// What is read again of a run.
void expect_same(const RunFacts &read, const RunFacts &written) {
    EXPECT_EQ(read.until_s, written.until_s);
    EXPECT_EQ(read.scene.file, written.scene.file);
    EXPECT_EQ(read.scene.sha256, written.scene.sha256);
    EXPECT_TRUE(read.notes == written.notes);
    ASSERT_EQ(read.devices.size(), written.devices.size());
    for (std::size_t i = 0; i < read.devices.size(); ++i) {
        EXPECT_EQ(read.devices[i].toml, written.devices[i].toml);
    }
    ASSERT_EQ(read.records.size(), written.records.size());
    for (std::size_t i = 0; i < read.records.size(); ++i) {
        EXPECT_EQ(read.records[i].file, written.records[i].file);
        EXPECT_EQ(read.records[i].start_s, written.records[i].start_s);
        EXPECT_EQ(read.records[i].device, written.records[i].device);
    }
}

void expect_one_line_about(const std::string &said, const std::string &file,
                           const std::string &problem) {
    EXPECT_NE(said.find(file), std::string::npos) << said << "\nand not about " << file;
    EXPECT_NE(said.find(problem), std::string::npos) << said << "\nand not " << problem;
    EXPECT_EQ(said.find('\n'), std::string::npos) << said;
}

TEST(RunFolder, IsNamedByTheTimeAndNeverOneThatExists) {
    const auto parent = fresh_folder("run_names");
    const std::time_t now = std::time(nullptr);
    for (std::time_t second = now; second < now + 5; ++second) { // as a file, and as a broken link
        std::tm parts{};
        localtime_r(&second, &parts);
        std::array<char, 64> name{};
        std::strftime(name.data(), name.size(), "springdrive-%Y%m%d-%H%M%S", &parts);
        testing::write_file(parent / name.data(), "a file");
        std::filesystem::create_symlink("nowhere", parent / (std::string(name.data()) + "-2"));
    }
    std::set<std::filesystem::path> made;
    for (int i = 0; i < 5; ++i) {
        const RunFolder folder = RunFolder::create(parent);
        EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
        EXPECT_TRUE(made.insert(folder.path()).second);
        EXPECT_TRUE(without_digits(folder.path()).starts_with("springdrive-00000000-000000-0"));
    }
    const RunFolder plain = RunFolder::create(fresh_folder("run_name"));
    EXPECT_EQ(without_digits(plain.path()), "springdrive-00000000-000000");
}

TEST(RunFolder, ThatCannotBeMadeIsRefused) {
    const auto parent = fresh_folder("run_refused");
    testing::write_file(parent / "file", "");
    const auto refusal = [](const std::filesystem::path &in) {
        return error_text_of([&in] { static_cast<void>(RunFolder::create(in)); });
    };
    expect_one_line_about(refusal(parent / "none"), "none/springdrive-", "No such file");
    expect_one_line_about(refusal(parent / "file"), "file/springdrive-", "Not a directory");
    std::filesystem::permissions(parent, std::filesystem::perms(0555));
    const std::string said =
        testing::said_in_child(testing::drop_rights, [&] { return refusal(parent); });
    expect_one_line_about(said, "springdrive-", "Permission denied");
    std::filesystem::permissions(parent, std::filesystem::perms(0755));
    EXPECT_EQ(names_in(parent), std::set<std::string>{"file"});
}

TEST(RunFolder, OnAFullDiskLeavesNothingBehind) {
    const auto parent = fresh_folder("run_full");
    const auto expect_refused = [&] {
        expect_one_line_about(error_text_of([&] { static_cast<void>(RunFolder::create(parent)); }),
                              "springdrive-", "is the disk full?");
        EXPECT_TRUE(std::filesystem::is_empty(parent));
    };
    {
        const FullDisk disk(1000);
        expect_refused();
    }
    if (mount("none", parent.c_str(), "tmpfs", 0, "size=32k") != 0) {
        GTEST_SKIP() << "mounting a small disk takes root";
    }
    expect_refused();
    umount(parent.c_str());
}

TEST(RunFolder, GivesBackWhatWasSaved) {
    const RunFolder folder = RunFolder::create(fresh_folder("run_saved"));
    for (RunFacts facts : {some_facts(), RunFacts{}}) {
        facts.devices.resize(std::max(std::size_t{1}, facts.devices.size()));
        folder.save(facts);
        expect_same(read_run(folder.path()), facts);
    }
    RunFacts facts = some_facts();
    facts.notes.assign(20U << 20U, '\n'); // huge
    folder.save(facts);
    expect_same(read_run(folder.path()), facts);
    for (const auto &[name, tuning] : {std::pair{"slot_a.toml", facts.slots.other()},
                                       {"slot_b.toml", facts.slots.now()},
                                       {"tuning.toml", facts.slots.now()}}) {
        EXPECT_TRUE(control::read_tuning_file(folder.path() / name) == tuning) << name;
    }
    EXPECT_EQ(names_in(folder.path()),
              (std::set<std::string>{"device.toml", "device-2.toml", "events.csv", "notes.txt",
                                     "run.json", "slot_a.toml", "slot_b.toml", "tuning.toml",
                                     "tuning_history.csv"}));
    EXPECT_EQ(contents_of(folder.path() / "device-2.toml"), "second = 2\n");
}

TEST(RunFolder, IsReadableForPeopleAndSpreadsheets) {
    const RunFolder folder = RunFolder::create(fresh_folder("run_text"));
    RunFacts facts = some_facts();
    facts.journal = {{0.0, 1.5, "K_P 6 → 8, \"by hand\"", {}}};
    facts.events = {{0.25, "reset"}};
    folder.save(facts);
    EXPECT_EQ(contents_of(folder.path() / "tuning_history.csv"),
              "\xEF\xBB\xBF" // the arrow is not ASCII
              "began_s,time_s,what,dR_Ohm,K_P_V_per_rad,K_D_Vs_per_rad,lambda_rad_per_s,"
              "alpha_rad2_per_m2,eta,map,alpha_mode\n"
              "0,1.5,\"K_P 6 → 8, \"\"by hand\"\"\",0.5,6,0.01,1000,3000,0,transpose,on_the_fly\n");
    EXPECT_EQ(contents_of(folder.path() / "events.csv"), "time_s,text\n0.25,reset\n");
    EXPECT_EQ(contents_of(folder.path() / "notes.txt"), kHardText);
    std::string json = contents_of(folder.path() / "run.json");
    std::erase_if(json, [](char c) { return c == ' ' || c == '\n'; });
    EXPECT_EQ(json, kRunJson);
}

TEST(RunFolder, NamesFilesSoThatItCanBeMovedAway) {
    const auto parent = fresh_folder("run_moved");
    const RunFolder folder = RunFolder::create(parent);
    RunFacts facts = some_facts();
    facts.scene.file = "scenes/../plate.gltf";
    facts.records = {{folder.path() / "past.rec", 0.0, 0},
                     {std::filesystem::relative(folder.path()) / "record.rec", 0.0, 0},
                     {"../elsewhere/touch.rec", 0.0, 0},
                     {"bare.rec", 0.0, 0}};
    facts.screenshots = {folder.next_screenshot()};
    folder.save(facts);
    std::filesystem::rename(folder.path(), parent / "moved");
    std::filesystem::create_directory_symlink(parent / "moved", parent / "linked");
    const RunFacts read = read_run(parent / "linked");
    EXPECT_EQ(read.scene.file, std::filesystem::current_path() / "plate.gltf");
    EXPECT_EQ(read.records[0].file, "past.rec");
    EXPECT_EQ(read.records[1].file, "record.rec");
    EXPECT_EQ(read.records[2].file,
              std::filesystem::current_path().parent_path() / "elsewhere/touch.rec");
    EXPECT_EQ(read.records[3].file, "bare.rec");
    EXPECT_NE(contents_of(parent / "linked/run.json").find("\"screenshot-1.png\""),
              std::string::npos);
}

TEST(RunFolder, KeepsWhatItHadIfTheDiskIsFull) {
    const RunFolder folder = RunFolder::create(fresh_folder("run_half"));
    const RunFacts before = some_facts();
    folder.save(before);
    const std::set<std::string> files = names_in(folder.path());
    RunFacts facts = before;
    facts.notes.assign(100'000, 'x');
    facts.software = "later";
    {
        const FullDisk disk(50'000);
        expect_one_line_about(error_text_of([&] { folder.save(facts); }), "notes.txt",
                              "as it was; is the disk full?");
    }
    EXPECT_EQ(names_in(folder.path()), files); // no temporary files either
    expect_same(read_run(folder.path()), before);
    folder.save(facts);
    expect_same(read_run(folder.path()), facts);
}

TEST(RunFolder, WithAFolderInAFilesPlaceIsRefused) {
    const RunFolder folder = RunFolder::create(fresh_folder("run_blocked"));
    std::filesystem::create_directory(folder.path() / "notes.txt");
    expect_one_line_about(error_text_of([&] { folder.save(some_facts()); }), "notes.txt",
                          "is not a regular file");
    std::filesystem::remove_all(folder.path());
    expect_one_line_about(error_text_of([&] { folder.save(some_facts()); }), "device.toml",
                          "No such file");
}

TEST(RunFolder, NumbersItsScreenshots) {
    const RunFolder folder = RunFolder::create(fresh_folder("run_pictures"));
    EXPECT_EQ(folder.next_screenshot(), folder.path() / "screenshot-1.png");
    testing::write_file(folder.path() / "screenshot-1.png", "");
    std::filesystem::create_symlink("nowhere", folder.path() / "screenshot-2.png");
    EXPECT_EQ(folder.next_screenshot(), folder.path() / "screenshot-3.png");
}

class ReadRun : public ::testing::Test {
protected:
    ReadRun() {
        folder.save(some_facts());
        json = contents_of(folder.path() / "run.json");
    }
    [[nodiscard]] std::string error() const {
        return error_text_of([this] { static_cast<void>(read_run(folder.path())); });
    }
    /// With another text in a file.
    [[nodiscard]] std::string error_with(const std::string &file, const std::string &text) const {
        const std::string before = contents_of(folder.path() / file);
        testing::write_file(folder.path() / file, text);
        std::string said = error();
        testing::write_file(folder.path() / file, before);
        return said;
    }
    /// With one part of run.json replaced.
    [[nodiscard]] std::string error_after(const std::string &part, const std::string &by) const {
        std::string changed = json;
        const std::size_t at = changed.find(part);
        EXPECT_NE(at, std::string::npos) << part;
        return error_with("run.json", changed.replace(at, part.size(), by));
    }

    RunFolder folder = RunFolder::create(fresh_folder("run_read"));
    std::string json;
};

TEST_F(ReadRun, RefusesWhatItMustNotBelieve) {
    const std::vector<std::array<std::string, 3>> cases{
        {"\"springdrive run 1\"", "\"springdrive run 2\"", "format is 'springdrive run 2'"},
        {"\"springdrive run 1\"", "1", "format is 1"},
        {"\"format\"", "\"form\"", "format is missing"},
        {"4000.0", "NaN", "is no JSON"},
        {"4000.0", "1e999", "is no JSON"},
        {"0.30000000000000004", "null", "until_s is a value of type null; it must be a number"},
        {"0.30000000000000004", "\"now\\nor then\"", "until_s is 'now or then'; it must be a"},
        {"\"until_s\"", "\"until\"", "until_s is missing"},
        {"\"devices\"", "\"device\"", "devices is missing"},
        {"\"0123abcd\"", "true", "scene.sha256 is a value of type boolean"},
        {"\"records\"", "\"recorded\"", "records is missing"},
        {"\"past.rec\"", "\"../past.rec\"", "records[0].file is '../past.rec'"},
        {"\"past.rec\"", "\"in/past.rec\"", "records[0].file is 'in/past.rec'"},
        {"\"past.rec\"", "\"..\"", "records[0].file is '..'"},
        {"\"past.rec\"", "\"\"", "records[0].file is ''"},
        {"\"past.rec\"", R"("past.rec\u0000")", "records[0].file"},
        {"\"past.rec\"", "[]", "records[0].file is a value of type array"},
        {R"("device": "device.toml")", R"("device": "device-3.toml")", "records[0].device"}};
    for (const auto &[part, by, problem] : cases) {
        expect_one_line_about(error_after(part, by), (folder.path() / "run.json").string(),
                              problem);
    }
    for (const char *text : {"", "[]", "7", "null", "\xff\xfe", "{}}"}) {
        expect_one_line_about(error_with("run.json", text), "run.json", ": ");
    }
    EXPECT_EQ(error(), "");
}

TEST_F(ReadRun, AcceptsWhatIsNewOrLost) {
    EXPECT_EQ(error_after("\"software\"", "\"colour\": \"red\", \"software\""), "");
    std::filesystem::remove(folder.path() / "notes.txt");
    std::filesystem::remove(folder.path() / "tuning_history.csv"); // for people
    EXPECT_EQ(read_run(folder.path()).notes, "");
    const std::string text = contents_of(folder.path() / "device-2.toml");
    std::filesystem::remove(folder.path() / "device-2.toml");
    expect_one_line_about(error(), "device-2.toml", "");
    testing::write_file(folder.path() / "device-2.toml", text);
    EXPECT_EQ(error(), "");
}

TEST_F(ReadRun, OfATruncatedTextIsRefusedWhereverItEnds) {
    for (std::size_t length = 0; length + 3 < json.size(); length += 11) {
        expect_one_line_about(error_with("run.json", json.substr(0, length)), "run.json",
                              "is no JSON");
    }
}

TEST_F(ReadRun, OfRandomBytesNeverFailsOtherwise) {
    std::mt19937_64 random(1);
    for (int trial = 0; trial < 150; ++trial) {
        std::string changed = json;
        for (std::uint64_t i = 0; i <= random() % 4; ++i) {
            changed[random() % changed.size()] = static_cast<char>(random());
        }
        const std::string said = error_with("run.json", changed);
        EXPECT_EQ(said.find('\n'), std::string::npos) << said;
    }
    for (const char *deep : {"[", "{\"a\":"}) {
        std::string text;
        for (int i = 0; i < 200'000; ++i) {
            text += deep;
        }
        expect_one_line_about(error_with("run.json", text), "run.json", "is no JSON");
    }
}

TEST_F(ReadRun, RefusesWhatIsNoFolderOfARun) {
    const auto other = fresh_folder("run_other");
    const auto expect_refused = [](const std::filesystem::path &path, const std::string &file,
                                   const std::string &problem) {
        expect_one_line_about(error_text_of([&path] { static_cast<void>(read_run(path)); }), file,
                              problem);
    };
    expect_refused(other, other.string(), "has no run.json");
    expect_refused(other / "none", "none", "has no run.json");
    testing::write_file(other / "file", "");
    expect_refused(other / "file", "file", "has no run.json");
    std::filesystem::create_directory(other / "run.json");
    expect_refused(other, "run.json", "is a folder");
    std::filesystem::remove(other / "run.json");
    std::filesystem::create_symlink("run.json", other / "run.json"); // to itself
    expect_refused(other, "run.json", "cannot be read");
}

/// Rows of random bits, of which the first are of another device.
class PastRecordTest : public ::testing::Test {
protected:
    void add(std::size_t rows) {
        TelemetryHistory history(testing::phantom_1_0().geometry, testing::kServo_hz);
        for (servo::ServoSample &sample :
             testing::random_samples(rows, testing::kServo_hz, past.store.end())) {
            sample.tick += past.store.end();
            // Integers of more than 53 bits are no numbers of ticks or measurements.
            sample.measurement_number %= std::uint64_t{1} << 53U;
            past.store.add(sample.time_s + static_cast<double>(past.store.end()),
                           history.row_of(sample));
            added.push_back(testing::row_of(sample));
        }
        past.rows.to = past.store.end();
    }
    [[nodiscard]] std::string error(BackgroundTalk &&talk = {}) {
        return error_text_of([&] { write_record(file, past, talk); });
    }

    std::vector<std::string> added; ///< as rows of a record
    std::filesystem::path folder = fresh_folder("past_record");
    std::filesystem::path file = folder / "past.rec";
    Record past{record::record_header(testing::kServo_hz), testing::phantom_1_0(),
                record::ChannelStore(channels().size(), TelemetryHistory::kMaxBytes)};
};

/// Rows and notes of a record, one after another.
std::vector<std::string> contents_of_record(const std::filesystem::path &file) {
    std::vector<std::string> contents;
    record::RecordReader reader(file);
    reader.for_each(
        [&](const servo::ServoSample &sample) { contents.push_back(testing::row_of(sample)); },
        [&](std::string_view note) { contents.emplace_back(note); });
    EXPECT_EQ(reader.ending().why, "");
    return contents;
}

TEST_F(PastRecordTest, HoldsEveryBitAndEachNoteInItsPlace) {
    add(2500);
    past.rows.from = 100;
    past.notes = {{3, "\"before\""},
                  {100, "\"first\""},
                  {2000, "\"a\""},
                  {2000, "\"b\""},
                  {2500, "\"last\""}};
    BackgroundTalk talk;
    write_record(file, past, talk);
    std::vector<std::string> expected;
    auto note = past.notes.begin();
    for (std::uint64_t row = 100; row <= 2500; ++row) {
        for (; note != past.notes.end() && note->before_row <= row; ++note) {
            expected.push_back(note->json);
        }
        if (row < 2500) {
            expected.push_back(added[row]);
        }
    }
    EXPECT_TRUE(contents_of_record(file) == expected);
    const record::RecordReader reader(file);
    const servo::ServoSample first = sample_at(past.store, 100);
    EXPECT_EQ(reader.header().tuning.map, first.tuning.map);
    EXPECT_GT(talk.share, 0.5);
    EXPECT_EQ(talk.what(), "writing past.rec");
}

TEST_F(PastRecordTest, BeginsWithTheFirstRowThatIsStillKept) {
    past.store = record::ChannelStore(channels().size(), 1); // two chunks
    add(6000);
    ASSERT_GT(past.store.begin(), 3000U);
    past.drop_before(past.store.begin());
    BackgroundTalk talk;
    write_record(file, past, talk);
    const std::vector<std::string> rows = contents_of_record(file);
    ASSERT_EQ(rows.size(), past.store.end() - past.store.begin());
    EXPECT_TRUE(rows.front() == added[past.store.begin()]);
    EXPECT_TRUE(rows.back() == added.back());
}

TEST_F(PastRecordTest, WithoutRowsIsARecordOfItsNotes) {
    past.notes = {{0, "{}"}};
    EXPECT_EQ(error(), "");
    EXPECT_EQ(contents_of_record(file), std::vector<std::string>{"{}"});
    add(10);
    past.rows = {10, 10}; // of a device that has not yet run
    file = folder / "another.rec";
    EXPECT_EQ(error(), "");
    EXPECT_EQ(contents_of_record(file), std::vector<std::string>{"{}"});
}

TEST_F(PastRecordTest, LeavesNothingBehindIfItIsCancelled) {
    add(3000);
    BackgroundTalk talk;
    talk.is_cancelled = true;
    EXPECT_THROW(write_record(file, past, talk), Cancelled);
    EXPECT_TRUE(std::filesystem::is_empty(folder));
    Background<bool> writing;
    writing.start([past = past, file = file](BackgroundTalk &own) {
        for (;;) { // until it is cancelled in the middle of one
            write_record(file, past, own);
            std::filesystem::remove(file);
        }
        return true;
    });
    while (!std::filesystem::exists(file)) {
    }
    writing.ask_to_end();
    EXPECT_THROW(while (!writing.take()){}, Cancelled);
    EXPECT_TRUE(std::filesystem::is_empty(folder));
}

TEST_F(PastRecordTest, LeavesNothingBehindOnAFullDisk) {
    add(3000);
    const std::uint64_t some = testing::expected_bytes(1000, past.header);
    const std::pair<std::uint64_t, const char *> cases[]{
        {some, "of 3000 ticks; is the disk full? Nothing of it is kept"},
        {100, "nothing was recorded"}};
    for (const auto &[room_bytes, said] : cases) {
        const FullDisk disk(room_bytes);
        expect_one_line_about(error(), file, said);
        EXPECT_TRUE(std::filesystem::is_empty(folder));
    }
}

TEST_F(PastRecordTest, ReplacesNoFileAndRefusesAnEndlessNote) {
    add(10);
    testing::write_file(file, "mine");
    expect_one_line_about(error(), file, "exists already");
    EXPECT_EQ(contents_of(file), "mine");
    file = folder / "another.rec";
    past.notes = {{5, std::string(record::RecordWriter::kMaxNote + 1, ' ')}};
    expect_one_line_about(error(), file, "is too long");
    EXPECT_FALSE(std::filesystem::exists(file));
    file = folder / "none/past.rec";
    expect_one_line_about(error(), file, "No such file");
}

} // namespace
} // namespace springdrive::session
