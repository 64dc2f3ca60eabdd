// Covers app/doctor/machine.cpp: files of a system that are not as they should be.
#include "app/doctor/machine.h"

#include "tests/app/doctor/laid_out_computer.h"

#include <sys/stat.h>

#include <cstdlib>

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

} // namespace
} // namespace springdrive::app::doctor
