// Covers app/doctor/real_time_checks.cpp: for each way in which a right is missing, the line that
// brings it; each line about the kernel from both sides.
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

} // namespace
} // namespace springdrive::app::doctor
