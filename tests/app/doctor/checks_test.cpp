// Covers app/doctor/{real_time_checks,usb_checks}.cpp: for each way in which a right is missing and
// for each obstacle before a board, the line that removes it; each line about the kernel from both
// sides.
#include "tests/app/doctor/laid_out_computer.h"

#include <cerrno>

namespace springdrive::app::doctor {
namespace {

const std::string kLimitsFile = "/etc/security/limits.d/springdrive.conf";

/// An ordinary installation without any rights for anna, who is in another group than this
/// program's.
LaidOutComputer fresh_installation() {
    LaidOutComputer computer;
    computer.has("/etc/passwd", "root:x:0:0::/root:/bin/bash\nanna:x:1000:1000::/home/anna:\n");
    computer.has("/etc/group", "root:x:0:\nplugdev:x:46:anna\nanna:x:1000:\n");
    computer.has("/etc/security/limits.conf",
                 "#@springdrive - rtprio 90\n@plugdev - rtprio 90\n* soft core 0\n");
    return computer;
}

Evidence refused(const LaidOutComputer &computer) {
    Evidence evidence = computer.evidence();
    evidence.probes.rights = {true, 80, EPERM, false, true};
    evidence.process.memory_lock_limit_bytes = 8'388'608; // 8 MiB
    evidence.process.memory_lock_limit_hard_bytes = 8'388'608;
    return evidence;
}

TEST(DoctorRights, ALineBringsBothLimitsAndTheGroup) {
    const Evidence evidence = refused(fresh_installation());
    const std::string line =
        "printf '@springdrive - %s\\n' 'rtprio 90' 'memlock unlimited' | sudo tee " + kLimitsFile +
        " && sudo groupadd --system springdrive && sudo usermod -aG springdrive \"$USER\"  # then "
        "log in again";
    expect_wrong(priority_check(evidence), Verdict::warning,
                 "SCHED_FIFO 80 refused: Operation not permitted; the limit is 0", line);
    expect_wrong(memory_lock_check(evidence), Verdict::warning, "the limit is 8192 kB", line);
}

TEST(DoctorRights, TheSourceTreesOwnFileIsCopied) {
    LaidOutComputer computer = fresh_installation();
    computer.has("/source/setup/limits.conf");
    computer.has("/etc/group", "springdrive:x:46:bert\n");
    EXPECT_EQ(priority_check(refused(computer)).fix,
              "sudo cp " + (computer.root() / "source/setup/limits.conf").string() + " " +
                  kLimitsFile + " && sudo usermod -aG springdrive \"$USER\"  # then log in again");
}

TEST(DoctorRights, OnlyWhatIsMissingIsInTheLine) {
    LaidOutComputer computer = fresh_installation();
    computer.has("/etc/group", "springdrive:x:46:bert\n");
    computer.has(kLimitsFile,
                 "# the servo\n@springdrive - rtprio 90\n@springdrive  -  memlock unlimited\n");
    EXPECT_EQ(priority_check(refused(computer)).fix,
              "sudo usermod -aG springdrive \"$USER\"  # then log in again");
    EXPECT_EQ(memory_lock_check(refused(computer)).fix,
              "sudo usermod -aG springdrive \"$USER\"  # then log in again");
    computer.has("/etc/group", "springdrive:x:46:bert,anna\n");
    EXPECT_EQ(priority_check(refused(computer)).fix,
              "log in again: limits and groups apply from a login on");
    computer.has("/etc/group", "springdrive:x:46:bert,annabel\n");
    Evidence member = refused(computer);
    member.process.group_ids = {1000, 46};
    EXPECT_EQ(priority_check(member).fix, "log in again: limits and groups apply from a login on");
    computer.has(kLimitsFile, "#@springdrive - rtprio 90\n@springdrive - nofile 90\n");
    EXPECT_EQ(priority_check(member).fix.substr(0, 6), "printf");
    EXPECT_EQ(priority_check(member).fix.find("usermod"), std::string::npos);
}

TEST(DoctorRights, AUsersOwnLineNeedsNoGroup) {
    LaidOutComputer computer = fresh_installation();
    computer.has(kLimitsFile, "anna - rtprio 80\n");
    EXPECT_EQ(priority_check(refused(computer)).fix, "log in again: limits apply from a login on");
    EXPECT_EQ(memory_lock_check(refused(computer)).fix.substr(0, 6), "printf");
    computer.has(kLimitsFile, "bert - rtprio 80\n");
    EXPECT_EQ(priority_check(refused(computer)).fix.substr(0, 6), "printf");
}

TEST(DoctorRights, ALimitThatTheUserMayRaiseIsRaised) {
    Evidence evidence = refused(fresh_installation());
    evidence.probes.rights.priority = 81;
    evidence.process.priority_limit_hard = 81;
    evidence.process.memory_lock_limit_hard_bytes = Process::kUnlimited;
    EXPECT_EQ(priority_check(evidence).fix, "ulimit -S -r 81");
    EXPECT_EQ(memory_lock_check(evidence).fix, "ulimit -S -l unlimited");
    evidence.process.priority_limit_hard = 80; // one too low for a board's thread
    evidence.process.memory_lock_limit_hard_bytes = std::uint64_t{1} << 40U;
    EXPECT_EQ(priority_check(evidence).fix.substr(0, 6), "printf");
    EXPECT_EQ(memory_lock_check(evidence).fix.substr(0, 6), "printf");
}

TEST(DoctorRights, ARefusalInSpiteOfTheLimitIsThatOfAGroupOfTasks) {
    Evidence evidence = refused(fresh_installation());
    evidence.process.priority_limit = 90;
    EXPECT_EQ(priority_check(evidence).fix, "sudo sysctl -w kernel.sched_rt_runtime_us=-1");
}

TEST(DoctorRights, InAContainerTheRightsComeFromItsStart) {
    LaidOutComputer computer = fresh_installation();
    computer.has("/.dockerenv");
    const std::string line =
        "start the container with --cap-add SYS_NICE --ulimit rtprio=90 --ulimit memlock=-1";
    EXPECT_EQ(priority_check(refused(computer)).fix, line);
    Evidence root = refused(computer);
    root.process.user_id = 0;
    EXPECT_EQ(memory_lock_check(root).fix, line);
    computer.has_no("/.dockerenv");
    EXPECT_NE(priority_check(root).fix.find("capabilities"), std::string::npos);
}

TEST(DoctorRights, AGroupWithoutAShareOfRealTimeIsGivenOne) {
    LaidOutComputer computer = fresh_installation();
    const std::string file = "/sys/fs/cgroup/cpu,cpuacct/user/1/cpu.rt_runtime_us";
    computer.has("/proc/self/cgroup", "9:cpuset:/\n4:cpu,cpuacct:/user/1\n0::/\n");
    computer.has(file, "0\n");
    Evidence evidence = refused(computer);
    evidence.process.priority_limit = 90;
    expect_wrong(priority_check(evidence), Verdict::warning, "no share of real-time",
                 "echo 500000 | sudo tee " + file);
    computer.has(file, "1\n");
    EXPECT_EQ(priority_check(evidence).found.find("share"), std::string::npos);
    EXPECT_EQ(priority_check(evidence).fix, "sudo sysctl -w kernel.sched_rt_runtime_us=-1");
    // Without the limit the share does not help yet.
    computer.has(file, "0\n");
    EXPECT_EQ(priority_check(refused(computer)).fix.substr(0, 6), "printf");
}

TEST(DoctorRights, AContainersGroupIsTheTopmostThatItSees) {
    LaidOutComputer computer = fresh_installation();
    computer.has("/.dockerenv");
    computer.has("/proc/self/cgroup", "2:cpuacct:/docker/5f\n1:cpu:/docker/5f\n");
    computer.has("/sys/fs/cgroup/cpu/cpu.rt_runtime_us", "0\n");
    expect_wrong(priority_check(refused(computer)), Verdict::warning, "no share of real-time",
                 "start the container with --cap-add SYS_NICE --cpu-rt-runtime=500000 "
                 "--ulimit rtprio=90 --ulimit memlock=-1");
    computer.has("/sys/fs/cgroup/cpu/cpu.rt_runtime_us", "950000\n");
    EXPECT_EQ(priority_check(refused(computer)).fix.find("runtime"), std::string::npos);
}

TEST(DoctorRights, AreNeededByABoardAndMerelyGoodForASimulation) {
    const LaidOutComputer computer;
    expect_ok(priority_check(computer.evidence()), "SCHED_FIFO 80 granted");
    expect_ok(memory_lock_check(computer.evidence()), "RAM");
    Evidence evidence = refused(fresh_installation());
    evidence.purpose.uses_usb = true;
    EXPECT_EQ(name_of(priority_check(evidence).verdict), "failure");
    EXPECT_EQ(name_of(memory_lock_check(evidence).verdict), "failure");
    evidence.probes.rights = {};
    EXPECT_NE(priority_check(evidence).found.find("did not end"), std::string::npos);
}

const std::string kProcessors = "/sys/devices/system/cpu/";

TEST(DoctorGovernor, OneSlowProcessorOfManyIsFound) {
    LaidOutComputer computer;
    for (int i = 0; i < 12; ++i) {
        const std::string folder = kProcessors + "cpu" + std::to_string(i) + "/cpufreq/";
        computer.has(folder + "scaling_governor", "performance\n");
        computer.has(folder + "scaling_min_freq", "800000\n");
        computer.has(folder + "scaling_max_freq", "4200000\n");
    }
    computer.has(kProcessors + "cpufreq/scaling_governor", "powersave\n"); // no processor
    computer.has(kProcessors + "cpu12/online", "0\n");                     // is switched off
    expect_ok(governor_check(computer.evidence()), "performance on all 12");
    computer.has(kProcessors + "cpu10/cpufreq/scaling_governor", "powersave\n");
    expect_wrong(governor_check(computer.evidence()), Verdict::warning,
                 "powersave (800 to 4200 MHz) on 1 of 12",
                 "echo performance | sudo tee /sys/devices/system/cpu/cpu*/cpufreq/"
                 "scaling_governor");
    Evidence root = computer.evidence();
    root.process.user_id = 0;
    EXPECT_EQ(governor_check(root).fix.find("sudo"), std::string::npos);
}

TEST(DoctorGovernor, AMachineWithoutFrequenciesHasNoVerdict) {
    LaidOutComputer computer;
    computer.has(kProcessors + "cpu0/topology/core_id", "0");
    expect_no_verdict(governor_check(computer.evidence()), "virtual machine");
    computer.has(kProcessors + "cpu0/cpufreq/scaling_governor", ""); // unreadable or empty
    expect_no_verdict(governor_check(computer.evidence()), "virtual machine");
}

LaidOutComputer with_idle_states() {
    LaidOutComputer computer;
    for (const char *const processor : {"cpu0", "cpu1"}) {
        const std::string folder = kProcessors + processor + "/cpuidle/";
        computer.has(folder + "state0/name", "POLL\n");
        computer.has(folder + "state0/latency", "0\n");
        computer.has(folder + "state1/name", "C1\n");
        computer.has(folder + "state1/latency", "2\n");
    }
    computer.has(kProcessors + "cpu1/cpuidle/state2/name", "C10\n");
    computer.has(kProcessors + "cpu1/cpuidle/state2/latency", "890\n");
    computer.has(kProcessors + "cpu1/cpuidle/state2/disable", "0\n");
    computer.has("/dev/cpu_dma_latency");
    return computer;
}

TEST(DoctorIdle, ADeepStateIsWrongUnlessTheServoMayForbidIt) {
    LaidOutComputer computer = with_idle_states();
    Evidence evidence = computer.evidence();
    expect_ok(idle_check(evidence), "C10 takes 890 us to leave; the servo keeps");
    evidence.probes.rights.idle_is_short = false;
    expect_wrong(idle_check(evidence), Verdict::warning,
                 "C10 takes 890 us to leave, more than 100 us, a tenth of a tick",
                 "echo 'KERNEL==\"cpu_dma_latency\", MODE=\"0666\"' | sudo tee "
                 "/etc/udev/rules.d/99-springdrive.rules && sudo chmod 666 /dev/cpu_dma_latency");
    computer.has_no("/dev/cpu_dma_latency");
    EXPECT_EQ(idle_check(evidence).fix,
              "echo 1 | sudo tee /sys/devices/system/cpu/cpu*/cpuidle/state[1-9]/disable");
    computer.has(kProcessors + "cpu1/cpuidle/state2/disable", "1\n");
    expect_ok(idle_check(evidence), "C1 takes 2 us");
}

TEST(DoctorIdle, TheBoundIsATenthOfATick) {
    Evidence none = LaidOutComputer().evidence();
    expect_ok(idle_check(none), "none are shown");
    none.probes.rights.idle_is_short = false;
    expect_no_verdict(idle_check(none), "none are shown");
    LaidOutComputer computer = with_idle_states();
    computer.has(kProcessors + "cpu1/cpuidle/state2/latency", "100");
    Evidence evidence = computer.evidence();
    evidence.probes.rights.idle_is_short = false;
    expect_ok(idle_check(evidence), "100 us");
    evidence.purpose.servo_hz = 1001.0;
    EXPECT_EQ(idle_check(evidence).verdict, Verdict::warning);
    evidence.purpose.servo_hz = 4000.0;
    EXPECT_NE(idle_check(evidence).found.find("more than 25 us"), std::string::npos);
}

TEST(DoctorShare, TheUsualShareIsEnoughAndNoneIsNot) {
    LaidOutComputer computer;
    expect_no_verdict(real_time_share_check(computer.evidence()), "no such limit");
    computer.has("/proc/sys/kernel/sched_rt_period_us", "1000000\n");
    computer.has("/proc/sys/kernel/sched_rt_runtime_us", "950000\n");
    expect_ok(real_time_share_check(computer.evidence()), "95 % of each 1 s");
    computer.has("/proc/sys/kernel/sched_rt_runtime_us", "-1\n");
    expect_ok(real_time_share_check(computer.evidence()), "unlimited");
    computer.has("/proc/sys/kernel/sched_rt_runtime_us", "0\n");
    expect_wrong(real_time_share_check(computer.evidence()), Verdict::warning, "0 % of each 1 s",
                 "sudo sysctl -w kernel.sched_rt_runtime_us=950000");
    Evidence usb = computer.evidence();
    usb.purpose.uses_usb = true;
    EXPECT_EQ(real_time_share_check(usb).verdict, Verdict::failure);
    computer.has("/proc/sys/kernel/sched_rt_period_us", "0\n");
    expect_no_verdict(real_time_share_check(usb), "no such limit");
}

TEST(DoctorKernel, PreemptRtIsToldByEitherSignAndMattersToABoard) {
    LaidOutComputer computer;
    computer.has("/proc/sys/kernel/osrelease", "6.1.0-rt-amd64\n");
    computer.has("/proc/sys/kernel/version", "#1 SMP PREEMPT_RT Debian 6.1.1\n");
    Evidence usb = computer.evidence();
    usb.purpose.uses_usb = true;
    expect_ok(preemption_check(usb), "Linux 6.1.0-rt-amd64, PREEMPT_RT");
    computer.has("/proc/sys/kernel/version", "#1 SMP PREEMPT_DYNAMIC Debian 6.1.1\n");
    expect_ok(preemption_check(computer.evidence()), "not PREEMPT_RT");
    computer.has("/etc/os-release", "ID=debian\n");
    expect_wrong(preemption_check(usb), Verdict::warning, "not PREEMPT_RT",
                 "sudo apt-get install linux-image-rt-amd64  # then restart");
    computer.has("/etc/os-release", "ID=ubuntu\nID_LIKE=debian\n");
    EXPECT_EQ(preemption_check(usb).fix, "sudo pro enable realtime-kernel");
    computer.has("/run/systemd/container", "lxc");
    EXPECT_NE(preemption_check(usb).fix.find("host"), std::string::npos);
    computer.has("/sys/kernel/realtime", "1\n");
    expect_ok(preemption_check(usb), "PREEMPT_RT");
}

using usb::BoardObstacle;

const std::string kBoard = "/sys/bus/usb/devices/1-2/";
const std::string kInterface = "/sys/bus/usb/devices/1-2:1.0/";

usb::SurveyedBoard good_board() {
    return {1, 5, "1-2", "A7", "high speed (480 Mbit/s)", "springdrive board 1.2.3", {}, ""};
}

/// A board in a port of the computer, with which nothing is wrong.
LaidOutComputer with_board() {
    LaidOutComputer computer;
    computer.has("/etc/os-release", "ID=debian\n");
    computer.has("/dev/bus/usb/001/005");
    for (const auto &[name, text] :
         std::vector<std::pair<std::string, std::string>>{{"idVendor", "1209\n"},
                                                          {"idProduct", "0001\n"},
                                                          {"busnum", "1\n"},
                                                          {"devnum", "5\n"},
                                                          {"serial", "A7\n"},
                                                          {"speed", "480\n"},
                                                          {"power/control", "on\n"}}) {
        computer.has(kBoard + name, text);
    }
    computer.has(kInterface + "bInterfaceClass", "ff\n");
    computer.has(kInterface + "bInterfaceSubClass", "53\n");
    return computer;
}

Evidence for_usb(const LaidOutComputer &computer,
                 const std::vector<usb::SurveyedBoard> &boards = {good_board()}) {
    Evidence evidence = computer.evidence();
    evidence.purpose.uses_usb = true;
    evidence.probes.usb.boards = boards;
    return evidence;
}

Evidence with_obstacle(const LaidOutComputer &computer, BoardObstacle obstacle,
                       const std::string &problem = "") {
    usb::SurveyedBoard board = good_board();
    board.obstacle = obstacle;
    board.problem = problem;
    return for_usb(computer, {board});
}

Check usb_check(const Evidence &evidence, const std::string &id) {
    return check_named(usb_checks(evidence), id);
}

TEST(DoctorUsb, AGoodBoardIsDescribed) {
    const Evidence evidence = for_usb(with_board());
    ASSERT_EQ(usb_checks(evidence).size(), 6U);
    for (const Check &check : usb_checks(evidence)) {
        EXPECT_NE(check.matters, "") << check.id;
    }
    expect_ok(usb_check(evidence, "usb_board"), "board A7");
    expect_ok(usb_check(evidence, "usb_permission"), "/dev/bus/usb/001/005 may be used");
    expect_ok(usb_check(evidence, "usb_firmware"), "springdrive board 1.2.3");
    expect_ok(usb_check(evidence, "usb_speed"), "480 Mbit/s");
    expect_ok(usb_check(evidence, "usb_autosuspend"), "on");
    expect_ok(usb_check(evidence, "usb_hub"), "1-2 is a port of the computer");
}

TEST(DoctorUsb, NoBoardFailsOnlyWhereOneIsAskedFor) {
    LaidOutComputer computer;
    const Evidence sim = computer.evidence();
    ASSERT_EQ(usb_checks(sim).size(), 1U);
    expect_no_verdict(usb_check(sim, "usb_board"),
                      "none is connected (vendor 1209, product 0001, interface ff/53)");
    expect_wrong(usb_check(for_usb(computer, {}), "usb_board"), Verdict::failure,
                 "none is connected", "use a computer that has USB: this one has no /dev/bus/usb");
    computer.has("/.dockerenv");
    expect_wrong(usb_check(for_usb(computer, {}), "usb_board"), Verdict::failure,
                 "none is connected",
                 "start the container with -v /dev/bus/usb:/dev/bus/usb --device-cgroup-rule "
                 "'c 189:* rmw'");
    computer.has("/dev/bus/usb/001/001");
    EXPECT_EQ(usb_check(for_usb(computer, {}), "usb_board").fix.substr(0, 17), "plug the board in");
    Evidence silent = for_usb(computer, {});
    silent.probes.usb.has_answered = false;
    EXPECT_EQ(usb_check(silent, "usb_board").found, "USB gave no answer in time");
}

TEST(DoctorUsb, OneOfSeveralIsNamed) {
    usb::SurveyedBoard other = good_board();
    other.serial = "B 8";
    other.sysfs_name = "1-3";
    other.address = 6;
    LaidOutComputer computer = with_board();
    computer.has("/dev/bus/usb/001/006");
    Evidence both = for_usb(computer, {other, good_board()});
    expect_wrong(usb_check(both, "usb_board"), Verdict::failure, "2: board B 8, board A7",
                 "springdrive --device usb:'B 8'");
    both.purpose.serial = "A7";
    expect_ok(usb_check(both, "usb_board"), "board B 8, board A7");
    EXPECT_EQ(usb_checks(both).size(), 6U); // of the one only
    both.purpose.serial = "C9";
    expect_wrong(usb_check(both, "usb_board"), Verdict::failure, "none has the serial number C9",
                 "springdrive --device usb:'B 8'");
    EXPECT_EQ(usb_checks(both).size(), 1U);
}

TEST(DoctorUsb, PermissionComesFromTheRuleThenFromPluggingIn) {
    LaidOutComputer computer = with_board();
    Evidence refused = with_obstacle(computer, BoardObstacle::no_permission);
    const std::string reload = " && sudo udevadm control --reload && sudo udevadm trigger "
                               "--attr-match=idVendor=1209";
    expect_wrong(usb_check(refused, "usb_permission"), Verdict::failure,
                 "/dev/bus/usb/001/005 may not be written to",
                 "echo '" + udev_rule() +
                     "' | sudo tee /etc/udev/rules.d/70-springdrive-usb.rules" + reload);
    expect_no_verdict(usb_check(refused, "usb_firmware"), "cannot be asked");
    computer.has("/source/setup/70-springdrive-usb.rules");
    EXPECT_EQ(usb_check(refused, "usb_permission").fix,
              "sudo cp " + (computer.root() / "source/setup/70-springdrive-usb.rules").string() +
                  " /etc/udev/rules.d/" + reload);
    computer.has("/etc/udev/rules.d/99-springdrive.rules", "KERNEL==\"cpu_dma_latency\"\n# 1209\n");
    EXPECT_NE(usb_check(refused, "usb_permission").fix.find("reload"), std::string::npos);
    computer.has("/usr/lib/udev/rules.d/70-springdrive-usb.rules", "ATTR{idVendor}==\"1209\"\n");
    EXPECT_EQ(usb_check(refused, "usb_permission").fix,
              "unplug the board and plug it in again: the rule for it is installed");
    refused.process.environment["SSH_CONNECTION"] = "10.0.0.1 1 10.0.0.2 22";
    EXPECT_EQ(usb_check(refused, "usb_permission").fix,
              "sudo chown \"$USER\" /dev/bus/usb/001/005");
    refused.purpose.uses_usb = false;
    EXPECT_EQ(usb_check(refused, "usb_permission").verdict, Verdict::warning);
}

/// As other products for tests may have, too.
TEST(DoctorUsb, ItsNumbersAloneMakeNoBoard) {
    LaidOutComputer computer = with_board();
    computer.has_no("/dev/bus/usb");
    computer.has("/sys/bus/usb/devices/1-3/idVendor", "1209\n");
    computer.has("/sys/bus/usb/devices/1-3/idProduct", "0001\n");
    computer.has("/sys/bus/usb/devices/1-3:1.0/bInterfaceClass", "ff\n");
    computer.has("/sys/bus/usb/devices/1-3:1.0/bInterfaceSubClass", "00\n");
    expect_ok(usb_check(for_usb(computer, {}), "usb_board"), "board A7");
    computer.has_no("/sys/bus/usb/devices/1-2");
    expect_wrong(usb_check(for_usb(computer, {}), "usb_board"), Verdict::failure,
                 "; 1-3 has these numbers, but not the interface",
                 "use a computer that has USB: this one has no /dev/bus/usb");
}

/// What is installed and what is printed are the same, and of the protocol's numbers.
TEST(DoctorUsb, TheRuleIsForAnInterfaceOfTheProtocol) {
    std::ifstream file(std::filesystem::path(SPRINGDRIVE_ASSET_DIR).parent_path() /
                       "setup/70-springdrive-usb.rules");
    std::vector<std::string> rules;
    for (std::string line; std::getline(file, line);) {
        if (!line.starts_with("#")) {
            rules.push_back(line);
        }
    }
    EXPECT_EQ(rules, std::vector<std::string>{udev_rule()});
    EXPECT_NE(udev_rule().find("ATTR{idVendor}==\"1209\", ATTR{idProduct}==\"0001\", "
                               "ENV{ID_USB_INTERFACES}==\"*:ff53??:*\""),
              std::string::npos);
}

TEST(DoctorUsb, ABoardWithoutANodeIsFoundByTheKernelsList) {
    LaidOutComputer computer = with_board();
    computer.has_no("/dev/bus/usb");
    const Evidence evidence = for_usb(computer, {}); // libusb sees none
    expect_ok(usb_check(evidence, "usb_board"), "board A7");
    expect_wrong(
        usb_check(evidence, "usb_permission"), Verdict::failure,
        "/dev/bus/usb/001/005 is missing, though the kernel has the board at 1-2",
        "sudo mkdir -p /dev/bus/usb/001 && sudo mknod -m 666 /dev/bus/usb/001/005 c 189 4");
    computer.has("/run/.containerenv");
    EXPECT_EQ(usb_check(evidence, "usb_permission").fix.substr(0, 19), "start the container");
}

TEST(DoctorUsb, TheProgramThatUsesABoardIsNamed) {
    LaidOutComputer computer = with_board();
    Evidence evidence = with_obstacle(computer, BoardObstacle::in_use);
    expect_wrong(usb_check(evidence, "usb_permission"), Verdict::failure, "used by another program",
                 "sudo fuser -v /dev/bus/usb/001/005  # names the program to end");
    computer.has("/proc/self/fd/none");
    computer.has_link("/proc/77/fd/3", "/dev/bus/usb/001/004");
    computer.has_link("/proc/4711/fd/9", "/dev/bus/usb/001/005");
    computer.has("/proc/4711/comm", "springdrive\n");
    expect_wrong(usb_check(evidence, "usb_permission"), Verdict::failure,
                 "used by springdrive, process 4711", "kill 4711");
    evidence.process.parent_id = 4711;
    expect_ok(usb_check(evidence, "usb_permission"), "springdrive that asks");
}

TEST(DoctorUsb, FirmwareThatDoesNotFitOrAnswerFails) {
    const LaidOutComputer computer = with_board();
    const Evidence old =
        with_obstacle(computer, BoardObstacle::wrong_version, "has versions 2 to 3");
    expect_wrong(usb_check(old, "usb_firmware"), Verdict::failure,
                 "springdrive board 1.2.3: has versions 2 to 3",
                 "install the firmware of this version of springdrive: docs/board.md");
    expect_ok(usb_check(old, "usb_permission"), "may be used");
    const Evidence silent = with_obstacle(computer, BoardObstacle::no_answer, "does not answer");
    EXPECT_NE(usb_check(silent, "usb_firmware").fix.find("unplug"), std::string::npos);
    EXPECT_EQ(usb_check(silent, "usb_firmware").verdict, Verdict::failure);
}

TEST(DoctorUsb, FullSpeedIsSlowAndTooSlowAbove1000Hz) {
    LaidOutComputer computer = with_board();
    computer.has(kBoard + "speed", "12\n");
    Evidence evidence = for_usb(computer);
    expect_wrong(usb_check(evidence, "usb_speed"), Verdict::warning, "12 Mbit/s",
                 "plug the board into another port, without a hub, by another cable");
    evidence.purpose.servo_hz = 1000.1;
    expect_wrong(usb_check(evidence, "usb_speed"), Verdict::failure, "12 Mbit/s",
                 "springdrive --device usb --servo-hz 1000");
    computer.has(kBoard + "speed", "5000\n");
    expect_ok(usb_check(evidence, "usb_speed"), "5000 Mbit/s");
    computer.has_no(kBoard + "speed"); // then libusb's word
    expect_ok(usb_check(evidence, "usb_speed"), "high speed");
    evidence.probes.usb.boards.front().speed = "full speed (12 Mbit/s)";
    EXPECT_EQ(usb_check(evidence, "usb_speed").verdict, Verdict::failure);
}

TEST(DoctorUsb, AutosuspendAndItsDelay) {
    LaidOutComputer computer = with_board();
    const Evidence evidence = for_usb(computer);
    computer.has(kBoard + "power/control", "auto\n");
    computer.has(kBoard + "power/autosuspend_delay_ms", "2000\n");
    expect_wrong(usb_check(evidence, "usb_autosuspend"), Verdict::warning,
                 "control is auto: suspended after 2000 ms unused",
                 "echo on | sudo tee /sys/bus/usb/devices/1-2/power/control");
    computer.has_no(kBoard + "power");
    expect_no_verdict(usb_check(evidence, "usb_autosuspend"), "not to be seen");
}

TEST(DoctorUsb, HubsAreCountedAndNamed) {
    LaidOutComputer computer = with_board();
    computer.has("/sys/bus/usb/devices/1-2/product", "USB2.0 Hub\n");
    Evidence evidence = for_usb(computer);
    evidence.probes.usb.boards.front().sysfs_name = "1-2.3.1";
    expect_wrong(usb_check(evidence, "usb_hub"), Verdict::warning,
                 "2 at 1-2.3.1; 1-2: USB2.0 Hub; 1-2.3: a hub",
                 "plug the board into the computer itself (one hub may be built into it)");
}

/// Whatever the files of a computer contain.
TEST(DoctorChecks, OddContentsAreBorne) {
    LaidOutComputer computer = with_board();
    computer.has_no("/dev/bus/usb");
    std::vector<std::string> files{"/etc/passwd",
                                   "/etc/group",
                                   "/etc/security/limits.conf",
                                   "/etc/security/limits.d/springdrive.conf",
                                   "/proc/99999999999999999999/comm",
                                   "/proc/sys/kernel/sched_rt_runtime_us",
                                   "/proc/sys/kernel/version",
                                   "/sys/kernel/realtime"};
    for (const char *const file :
         {"busnum", "devnum", "serial", "speed", "power/control", "power/autosuspend_delay_ms"}) {
        files.push_back(kBoard + file);
    }
    for (const char *const file :
         {"cpuidle/state2/latency", "cpuidle/state2/name", "cpuidle/state2/disable",
          "cpufreq/scaling_governor", "cpufreq/scaling_max_freq"}) {
        files.push_back(std::string("/sys/devices/system/cpu/cpu1/") + file);
    }
    computer.has("/proc/sys/kernel/sched_rt_period_us", "1000000\n");
    for (const std::string &odd :
         {std::string(), std::string("\n\n"), std::string("-1"), std::string("999999999999"),
          std::string("99999999999999999999999999"), std::string("-9223372036854775808"),
          std::string("9223372036854775807"), std::string("0x10"), std::string("12 13"),
          std::string("\xff\xfe\x80"), std::string(1'000'000, '7'), std::string("\0\0\0", 3),
          std::string(":::::\n::\n\n:"), std::string("springdrive:x:46:,,,,\n"),
          std::string(100'000, ':')}) {
        for (const std::string &file : files) {
            computer.has(file, odd);
        }
        for (Evidence evidence :
             {for_usb(computer, {}), with_obstacle(computer, BoardObstacle::none),
              with_obstacle(computer, BoardObstacle::in_use)}) {
            EXPECT_EQ(usb_checks(evidence).size(), 6U);
            evidence.probes.rights = {true, 80, EPERM, false, false};
            EXPECT_NE(priority_check(evidence).fix.find("usermod"), std::string::npos);
            for (const Check &check : all_checks(evidence)) {
                EXPECT_LT(check.found.size(), 800U) << check.id;
                EXPECT_EQ(check.found.find('\n'), std::string::npos) << check.id;
            }
        }
    }
}

} // namespace
} // namespace springdrive::app::doctor
