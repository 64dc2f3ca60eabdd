// Covers app/doctor/rights_checks.cpp: for each way in which a right is missing, the line that
// brings it.
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

TEST(DoctorRights, WhatIsGrantedIsNamed) {
    const LaidOutComputer computer;
    expect_ok(priority_check(computer.evidence()), "SCHED_FIFO 80 granted");
    expect_ok(memory_lock_check(computer.evidence()), "RAM");
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
    Evidence evidence = refused(fresh_installation());
    evidence.purpose.uses_usb = true;
    EXPECT_EQ(name_of(priority_check(evidence).verdict), "failure");
    EXPECT_EQ(name_of(memory_lock_check(evidence).verdict), "failure");
    evidence.probes.rights = {};
    EXPECT_NE(priority_check(evidence).found.find("did not end"), std::string::npos);
}

TEST(DoctorRights, OddFilesOfUsersAndGroupsAreBorne) {
    LaidOutComputer computer;
    for (const std::string &odd :
         {std::string(), std::string(":::::\n::\n\n:"), std::string("springdrive"),
          std::string("springdrive:x:46:,,,,\n"), std::string(100'000, ':'),
          std::string("\xff\xfe\0:", 4)}) {
        computer.has("/etc/passwd", odd);
        computer.has("/etc/group", odd);
        computer.has("/etc/security/limits.conf", odd);
        computer.has(kLimitsFile, odd);
        EXPECT_NE(priority_check(refused(computer)).fix.find("usermod"), std::string::npos);
    }
}

} // namespace
} // namespace springdrive::app::doctor
