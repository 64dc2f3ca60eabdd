// Covers app/doctor/{evidence,checks,picture_checks}.cpp and ChildAnswer of
// evidence.cpp.
#include "tests/app/doctor/laid_out_computer.h"

#include "app/doctor/checks.h"
#include "app/doctor/evidence.h"
#include "base/input_error.h"
#include "tests/support/files.h"
#include "tests/support/program.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <sys/stat.h>
#include <unistd.h>
#include <vector>

namespace springdrive::app::doctor {
namespace {

TEST(DoctorMachine, ReadsTextAndNumbers) {
    LaidOutComputer computer;
    computer.has("/sys/a", "  powersave\n");
    computer.has("/sys/n", "-12\n");
    EXPECT_EQ(computer.machine().text("/sys/a"), "powersave");
    EXPECT_EQ(computer.machine().number("/sys/n"), -12);
    EXPECT_EQ(computer.machine().number("/sys/a"), std::nullopt);
    EXPECT_EQ(computer.machine().text("/sys/none"), std::nullopt);
    EXPECT_EQ(Machine("/no/such/root").text("/sys/a"), std::nullopt);
    EXPECT_TRUE(Machine("/no/such/root").names_in("/sys").empty());
    EXPECT_FALSE(Machine("/no/such/root").is_container());
}

TEST(DoctorMachine, WaitsForNoPipeAndReadsNoFolderOrDevice) {
    LaidOutComputer computer;
    computer.has("/sys/other");
    ASSERT_EQ(mkfifo((computer.root() / "sys/pipe").c_str(), 0600), 0);
    computer.has_link("/sys/zero", "/dev/zero");
    computer.has_link("/sys/loop", "loop");
    for (const char *const file : {"/sys/pipe", "/sys", "/sys/zero", "/sys/loop"}) {
        EXPECT_EQ(computer.machine().text(file), std::nullopt) << file;
        EXPECT_TRUE(computer.machine().lines(file).empty()) << file;
    }
}

TEST(DoctorMachine, KeepsForeignLettersAndEndlessTextOut) {
    LaidOutComputer computer;
    computer.has("/sys/a", "caf\xc3\xa9\x1b[31m\n\xff");
    EXPECT_EQ(computer.machine().text("/sys/a"), "caf?? [31m ?");
    std::string endless;
    endless.resize(10'000'000, 'x');
    computer.has("/sys/a", endless);
    EXPECT_LT(computer.machine().text("/sys/a")->size(), 310U);
    EXPECT_LE(computer.machine().lines("/sys/a").front().size(), 256U * 1024U);
}

TEST(DoctorMachine, SortsNumbersAsNumbers) {
    LaidOutComputer computer;
    for (const char *const name : {"cpu10", "cpu9", "cpu1", "cpufreq", "cpu", "cpu100"}) {
        computer.has(std::string("/cpu/") + name);
    }
    EXPECT_EQ(computer.machine().names_in("/cpu"),
              (std::vector<std::string>{"cpu", "cpu1", "cpu9", "cpu10", "cpu100", "cpufreq"}));
}

TEST(DoctorMachine, NamesTheDistributionAndAContainer) {
    LaidOutComputer computer;
    EXPECT_FALSE(computer.machine().is_debian());
    computer.has("/etc/os-release", "ID=debian\n");
    EXPECT_TRUE(computer.machine().is_debian());
    EXPECT_FALSE(computer.machine().is_ubuntu());
    computer.has("/etc/os-release", "ID=fedora\nNAME=\"not debian\"\n");
    EXPECT_FALSE(computer.machine().is_debian());
    EXPECT_EQ(install_line(computer.machine(), {}, "gnuplot-nox"),
              "install what Debian calls gnuplot-nox");
    for (const char *const sign : {"/.dockerenv", "/run/.containerenv", "/run/systemd/container"}) {
        EXPECT_FALSE(computer.machine().is_container());
        computer.has(sign);
        EXPECT_TRUE(computer.machine().is_container());
        computer.has_no(sign);
    }
}

TEST(DoctorMachine, AShellReadsItsWordsBackUnchanged) {
    for (const std::string &word :
         {std::string("/a/b-c.d"), std::string("a b"), std::string("it's"),
          std::string("$HOME;`x`"), std::string("-rf"), std::string()}) {
        const std::string file = testing::fresh_folder("word") / "out";
        const std::string line = "printf %s " + shell_word(word) + " >" + file;
        ASSERT_EQ(std::system(line.c_str()), 0);
        EXPECT_EQ(testing::contents_of(file), word);
    }
}

TEST(DoctorMachine, ThisProcessIsOurs) {
    const Process process = this_process("/somewhere");
    EXPECT_EQ(process.setup_folder, "/somewhere");
    EXPECT_FALSE(process.group_ids.empty());
    EXPECT_EQ(process.variable("PATH"), std::getenv("PATH"));
    EXPECT_EQ(process.variable("NO_SUCH_VARIABLE"), "");
}

using std::chrono::milliseconds;

std::optional<std::string> answer_of(const std::function<std::string()> &work,
                                     milliseconds patience = milliseconds(20'000)) {
    ChildAnswer child(work);
    return child.by(ChildAnswer::Clock::now() + patience);
}

TEST(ChildAnswer, ReturnsWhatTheWorkReturns) {
    EXPECT_EQ(answer_of([] { return std::string("yes"); }), "yes");
    EXPECT_EQ(answer_of([] { return std::string(); }), "");
    const std::string much(1'000'000, 'x'); // more than a pipe holds
    EXPECT_EQ(answer_of([&] { return much; }), much);
}

TEST(ChildAnswer, ACrashIsNoAnswer) {
    EXPECT_EQ(answer_of([]() -> std::string {
                  std::raise(SIGKILL);
                  return "no";
              }),
              std::nullopt);
    EXPECT_EQ(answer_of([]() -> std::string { _exit(0); }), std::nullopt);
    EXPECT_EQ(answer_of([]() -> std::string { throw std::runtime_error("no"); }), std::nullopt);
}

TEST(ChildAnswer, TimeIsUpForWorkThatNeverEndsAndIgnoresSignals) {
    const auto start = ChildAnswer::Clock::now();
    EXPECT_EQ(answer_of(
                  []() -> std::string {
                      std::signal(SIGTERM, SIG_IGN);
                      for (;;) {
                          pause();
                      }
                  },
                  milliseconds(100)),
              std::nullopt);
    EXPECT_LT(ChildAnswer::Clock::now() - start, milliseconds(5'000));
}

TEST(ChildAnswer, WhatDriversPrintIsNotSeen) {
    ::testing::internal::CaptureStdout();
    EXPECT_EQ(answer_of([] {
                  std::puts("libGL: something");
                  std::fflush(stdout);
                  return std::string(std::getchar() == EOF ? "no input" : "input");
              }),
              "no input");
    EXPECT_EQ(::testing::internal::GetCapturedStdout(), "");
}

constexpr const char *kXvfb = "xvfb-run -a -s '-screen 0 1280x800x24' springdrive";

Evidence without_display(const LaidOutComputer &computer) {
    Evidence evidence = computer.evidence();
    evidence.probes.picture = {true, "X11: The DISPLAY environment variable is missing", "", "",
                               ""};
    return evidence;
}

TEST(DoctorPicture, ADisplayWithOpenGlIsDescribed) {
    Evidence evidence = LaidOutComputer().evidence();
    evidence.process.environment["DISPLAY"] = ":7";
    expect_ok(display_check(evidence), ":7");
    expect_ok(opengl_check(evidence), "4.6 (Core Profile) Mesa 23.2 on Mesa Intel UHD");
    EXPECT_EQ(opengl_check(evidence).found.find("processor"), std::string::npos);
    evidence.probes.picture.renderer = "llvmpipe (LLVM 15.0.6, 256 bits)";
    expect_ok(opengl_check(evidence), "drawn by the processor");
}

TEST(DoctorPicture, WithoutDisplayTheLineDependsOnWhereOneIs) {
    LaidOutComputer computer;
    computer.has("/etc/os-release", "ID=debian\n");
    Evidence evidence = without_display(computer);
    expect_wrong(display_check(evidence), Verdict::failure, "DISPLAY is not set",
                 std::string("sudo apt-get install xvfb && ") + kXvfb);
    expect_no_verdict(opengl_check(evidence), "no display");
    computer.has_program("/usr/bin/xvfb-run");
    EXPECT_EQ(display_check(evidence).fix, kXvfb);
    computer.has("/source/app/run");
    EXPECT_EQ(display_check(evidence).fix,
              (computer.root() / "source/app/run").string() +
                  "  # starts a virtual display, and installs it if necessary");
    evidence.process.environment["SSH_CONNECTION"] = "10.0.0.1 1 10.0.0.2 22";
    EXPECT_EQ(display_check(evidence).fix, "connect again by: ssh -X");
    evidence.process.environment["WAYLAND_DISPLAY"] = "wayland-0";
    EXPECT_EQ(display_check(evidence).fix, "sudo apt-get install xwayland  # then log in again");
}

TEST(DoctorPicture, ADisplayThatRefusesIsToldFromOneThatIsNotThere) {
    LaidOutComputer computer;
    computer.has_program("/usr/bin/xvfb-run");
    Evidence evidence = without_display(computer);
    evidence.probes.picture.display_problem = "X11: Failed to open display :1.0";
    evidence.process.environment["DISPLAY"] = ":1.0";
    EXPECT_EQ(display_check(evidence).fix, kXvfb);
    computer.has("/tmp/.X11-unix/X1");
    expect_wrong(display_check(evidence), Verdict::failure,
                 "DISPLAY=:1.0: X11: Failed to open display",
                 "xhost +si:localuser:$(id -un)  # by the person at that display");
    for (const char *const odd : {":", "", ":x", "host:1", "::1", "/tmp/a b:0"}) {
        evidence.process.environment["DISPLAY"] = odd;
        EXPECT_EQ(display_check(evidence).fix, kXvfb) << odd;
    }
    evidence.probes.picture = {}; // crashed or hangs
    EXPECT_EQ(display_check(evidence).verdict, Verdict::failure);
    EXPECT_EQ(opengl_check(evidence).verdict, Verdict::failure);
}

TEST(DoctorPicture, OpenGlThatIsTooOldFails) {
    LaidOutComputer computer;
    computer.has("/etc/os-release", "ID=debian\n");
    Evidence evidence = computer.evidence();
    evidence.probes.picture = {true, "", "GLX: Failed to create context: GLXBadFBConfig",
                               "2.1 Mesa 22.3.6", "Mesa Intel GMA"};
    expect_wrong(opengl_check(evidence), Verdict::failure, "2.1 Mesa 22.3.6 on Mesa Intel GMA",
                 "sudo apt-get install libgl1 libgl1-mesa-dri");
    evidence.process.environment["MESA_GL_VERSION_OVERRIDE"] = "2.1";
    EXPECT_EQ(opengl_check(evidence).fix, "unset MESA_GL_VERSION_OVERRIDE");
    evidence.probes.picture.version.clear();
    EXPECT_EQ(opengl_check(evidence).found.substr(0, 5), "none:");
}

TEST(DoctorPicture, IsNotNeededWithoutAWindow) {
    Evidence evidence = without_display(LaidOutComputer());
    evidence.purpose.has_window = false;
    for (const Finding &check : {display_check(evidence), opengl_check(evidence)}) {
        EXPECT_EQ(name_of(check.verdict), "not applicable");
        EXPECT_EQ(check.fix, "");
    }
}

TEST(DoctorDisk, IsComparedWithWhatARecordNeeds) {
    Evidence evidence = LaidOutComputer().evidence();
    const double needed = record_bytes_per_s(1000.0);
    EXPECT_GT(needed, 0.5e6);
    EXPECT_EQ(record_bytes_per_s(4000.0), 4.0 * needed);
    expect_ok(disk_check(evidence), "writes 200.0 MB/s, synchronised in 2.0 ms; a record needs");
    EXPECT_NE(disk_check(evidence).found.find("50.0 GB free"), std::string::npos);
    evidence.probes.disk.written_bytes_per_s = 4.01 * needed;
    EXPECT_EQ(disk_check(evidence).verdict, Verdict::ok);
    evidence.probes.disk.written_bytes_per_s = 3.99 * needed;
    EXPECT_EQ(disk_check(evidence).verdict, Verdict::warning);
    evidence.purpose.servo_hz = 4000.0;
    EXPECT_EQ(disk_check(evidence).verdict, Verdict::failure);
    EXPECT_NE(disk_check(evidence).fix, "");
}

TEST(DoctorDisk, LittleRoomIsAWarning) {
    Evidence evidence = LaidOutComputer().evidence();
    evidence.purpose.folder = "/data/my records";
    evidence.probes.disk.free_bytes = 601.0 * record_bytes_per_s(1000.0);
    EXPECT_EQ(disk_check(evidence).verdict, Verdict::ok);
    evidence.probes.disk.free_bytes = 599.0 * record_bytes_per_s(1000.0);
    expect_wrong(disk_check(evidence), Verdict::warning, "which last 10 min",
                 "du -xh '/data/my records' | sort -h | tail  # lists what takes the space");
}

TEST(DoctorDisk, EachRefusalHasItsLine) {
    Evidence evidence = LaidOutComputer().evidence();
    evidence.purpose.folder = "/data";
    const auto fix = [&](int refused) {
        evidence.probes.disk.refused = refused;
        EXPECT_EQ(disk_check(evidence).verdict, Verdict::failure);
        return disk_check(evidence).fix;
    };
    EXPECT_EQ(fix(ENOENT), "mkdir -p /data");
    EXPECT_EQ(fix(EACCES), "sudo chown \"$USER\" /data");
    EXPECT_EQ(fix(EROFS), "sudo mount -o remount,rw \"$(findmnt -n -o TARGET --target /data)\"");
    EXPECT_EQ(fix(ENOSPC), "du -xh /data | sort -h | tail  # lists what takes the space");
    EXPECT_NE(fix(EIO), "");
    evidence.probes.disk = {};
    EXPECT_NE(disk_check(evidence).found.find("did not write one second"), std::string::npos);
}

TEST(DoctorDisk, TheProbeWritesAndLeavesNothing) {
    const std::filesystem::path folder = testing::fresh_folder("disk");
    const DiskProbe probe = try_disk(folder, 100'000);
    EXPECT_EQ(probe.refused, 0);
    EXPECT_GT(probe.written_bytes_per_s, 0.0);
    EXPECT_GT(probe.free_bytes, 0.0);
    EXPECT_TRUE(std::filesystem::is_empty(folder));
    EXPECT_EQ(try_disk(folder / "none", 1000).refused, ENOENT);
    std::ofstream(folder / "file") << "x";
    EXPECT_EQ(try_disk(folder / "file", 1000).refused, ENOTDIR);
    EXPECT_NE(try_disk("/proc", 1000).refused, 0);
}

TEST(DoctorPackages, GnuplotIsLookedForAsTheSystemDoes) {
    LaidOutComputer computer;
    computer.has("/etc/os-release", "ID=debian\n");
    Evidence evidence = computer.evidence();
    evidence.process.environment["PATH"] = "relative::/usr/bin:/opt/bin";
    expect_wrong(gnuplot_check(evidence), Verdict::warning, "missing",
                 "sudo apt-get install gnuplot-nox");
    computer.has("/usr/bin/gnuplot"); // no program
    EXPECT_EQ(gnuplot_check(evidence).verdict, Verdict::warning);
    computer.has_program("/opt/bin/gnuplot");
    expect_ok(gnuplot_check(evidence), "/opt/bin/gnuplot");
    EXPECT_EQ(font_check(evidence).fix, "sudo apt-get install fonts-dejavu-core");
}

TEST(DoctorReport, JsonHasEveryFieldWhateverItsBytes) {
    DoctorReport report;
    report.version = "0.1.0";
    report.purpose.uses_usb = true;
    report.purpose.serial = "A7";
    report.checks = {{{Verdict::failure, "\xff\"\n", "sudo x"}, "a", "A", "because"},
                     {{Verdict::warning, ""}, "b", "B", ""},
                     {{Verdict::not_applicable, ""}, "c", "C", ""}};
    std::ostringstream out;
    write_json(out, report);
    const auto json = nlohmann::json::parse(out.str());
    EXPECT_EQ(json["device"], "usb:A7");
    EXPECT_EQ(json["failures"], 1);
    EXPECT_EQ(json["warnings"], 1);
    ASSERT_EQ(json["checks"].size(), 3U);
    EXPECT_EQ(json["checks"][0]["verdict"], "failure");
    EXPECT_EQ(json["checks"][0]["mend"], "sudo x");
    EXPECT_EQ(json["checks"][2]["verdict"], "not applicable");
    const std::vector<Check> read = checks_in(out.str());
    ASSERT_EQ(read.size(), 3U);
    EXPECT_EQ(read[0].id, "a");
    EXPECT_EQ(read[0].verdict, Verdict::failure);
    EXPECT_EQ(read[0].matters, "because");
    EXPECT_EQ(read[2].verdict, Verdict::not_applicable);
    EXPECT_FALSE(report.is_healthy());
    report.checks.erase(report.checks.begin());
    EXPECT_TRUE(report.is_healthy());
}

TEST(DoctorReport, WhatIsNoReportIsRefused) {
    for (
        const char *const text :
        {"", "{", "[]", "{}", R"({"checks":1})", R"({"checks":[{"id":"a"}]})",
         R"({"checks":[{"id":"a","title":"","verdict":"well","found":"","matters":"","mend":""}]})"}) {
        EXPECT_THROW(static_cast<void>(checks_in(text)), InputError) << text;
    }
}

TEST(DoctorReport, TextGivesALineToDoOnlyWhereSomethingIsWrong) {
    DoctorReport report;
    report.checks = {
        {{Verdict::failure, "broken", "mend it"}, "a", "the thing", "it breaks others"},
        {{Verdict::ok, "fine"}, "b", "another", "it matters"}};
    std::ostringstream out;
    write_text(out, report);
    EXPECT_NE(out.str().find("FAILURE  the thing: broken\n         why: it breaks others\n"
                             "         do:  mend it\nok       another: fine\n"
                             "1 failure, 0 warnings\n"),
              std::string::npos)
        << out.str();
}

} // namespace
} // namespace springdrive::app::doctor

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
    const std::string folder = testing::fresh_folder("doctor_disk") / "none";
    const testing::Ending ending =
        testing::run_program({"doctor", "--no-window", "--json", "--folder", folder});
    EXPECT_EQ(ending.exit_status, 1);
    EXPECT_EQ(check_of(json::parse(ending.out), "disk")["mend"], "mkdir -p " + folder);
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
