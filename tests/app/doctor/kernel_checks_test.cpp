// Covers app/doctor/kernel_checks.cpp, each line from both sides.
#include "tests/app/doctor/laid_out_computer.h"

namespace springdrive::app::doctor {
namespace {

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
    expect_no_verdict(governor_check(computer.evidence()), "virtual machine");
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

TEST(DoctorIdle, NoStatesAtAll) {
    Evidence evidence = LaidOutComputer().evidence();
    expect_ok(idle_check(evidence), "none are shown");
    evidence.probes.rights.idle_is_short = false;
    expect_no_verdict(idle_check(evidence), "none are shown");
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

TEST(DoctorKernel, OddContentsAreBorne) {
    LaidOutComputer computer = with_idle_states();
    computer.has("/proc/sys/kernel/sched_rt_period_us", "1000000\n");
    for (const std::string &odd :
         {std::string(), std::string("\n\n"), std::string("99999999999999999999999999"),
          std::string("-9223372036854775808"), std::string("9223372036854775807"),
          std::string("0x10"), std::string("12 13"), std::string("\xff\xfe\x80"),
          std::string(1'000'000, '7'), std::string("\0\0\0", 3)}) {
        for (const char *const file :
             {"cpu1/cpuidle/state2/latency", "cpu1/cpuidle/state2/name",
              "cpu1/cpuidle/state2/disable", "cpu1/cpufreq/scaling_governor",
              "cpu1/cpufreq/scaling_max_freq"}) {
            computer.has(kProcessors + file, odd);
        }
        computer.has("/proc/sys/kernel/sched_rt_runtime_us", odd);
        computer.has("/sys/kernel/realtime", odd);
        computer.has("/proc/sys/kernel/version", odd);
        Evidence evidence = computer.evidence();
        evidence.probes.rights.idle_is_short = false;
        for (const Check &check : all_checks(evidence)) {
            EXPECT_LT(check.found.size(), 800U);
            EXPECT_EQ(check.found.find('\n'), std::string::npos);
        }
    }
}

} // namespace
} // namespace springdrive::app::doctor
