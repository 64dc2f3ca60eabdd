// How the kernel treats the servo's thread: its share, preemption, idle states and frequency.
#include "app/doctor/checks.h"

#include <fmt/format.h>

#include <optional>
#include <string>

namespace springdrive::app::doctor {

namespace {

constexpr const char *kProcessors = "/sys/devices/system/cpu/";
constexpr const char *kIdleFile = "/dev/cpu_dma_latency";

/// Waking up may take this share of a period.
constexpr double kMaxWaking = 0.1;

/// Of each second; a servo needs a few per cent.
constexpr double kMinShare = 0.5;

std::vector<std::string> processors(const Machine &machine) {
    std::vector<std::string> all;
    for (const std::string &name : machine.names_in(kProcessors)) {
        if (name.size() > 3 && name.starts_with("cpu") &&
            name.find_first_not_of("0123456789", 3) == std::string::npos) {
            all.push_back(kProcessors + name);
        }
    }
    return all;
}

struct IdleState {
    std::string name;
    double waking_s = 0.0;
};

/// The one that takes longest to leave, of those that are not disabled.
std::optional<IdleState> deepest_idle(const Machine &machine) {
    std::optional<IdleState> deepest;
    for (const std::string &processor : processors(machine)) {
        for (const std::string &state : machine.names_in(processor + "/cpuidle")) {
            const std::string folder = processor + "/cpuidle/" + state;
            const std::optional<std::int64_t> waking_us = machine.number(folder + "/latency");
            if (!waking_us || machine.number(folder + "/disable").value_or(0) != 0) {
                continue;
            }
            const double waking_s = 1e-6 * static_cast<double>(*waking_us);
            if (!deepest || waking_s > deepest->waking_s) {
                deepest = {machine.text(folder + "/name").value_or(state), waking_s};
            }
        }
    }
    return deepest;
}

std::string megahertz(const Machine &machine, const std::string &file) {
    const std::optional<std::int64_t> kilohertz = machine.number(file);
    return kilohertz ? fmt::format("{:.0f}", 1e-3 * static_cast<double>(*kilohertz)) : "?";
}

} // namespace

Finding real_time_share_check(const Evidence &evidence) {
    const Machine &machine = evidence.machine;
    const auto runtime_us = machine.number("/proc/sys/kernel/sched_rt_runtime_us");
    const auto period_us = machine.number("/proc/sys/kernel/sched_rt_period_us");
    if (!runtime_us || !period_us || *period_us <= 0) {
        return {Verdict::not_applicable, "this kernel shows no such limit"};
    }
    if (*runtime_us < 0) {
        return {Verdict::ok, "unlimited"};
    }
    const double share = static_cast<double>(*runtime_us) / static_cast<double>(*period_us);
    Finding finding{Verdict::ok, fmt::format("{:.3g} % of each {:.3g} s", 100.0 * share,
                                             1e-6 * static_cast<double>(*period_us))};
    if (share < kMinShare) {
        finding.verdict = evidence.purpose.worse_with_usb();
        finding.fix = fmt::format("{}sysctl -w kernel.sched_rt_runtime_us={}",
                                  evidence.process.sudo(), *period_us - *period_us / 20);
    }
    return finding;
}

Finding preemption_check(const Evidence &evidence) {
    const Machine &machine = evidence.machine;
    const std::string release =
        machine.text("/proc/sys/kernel/osrelease").value_or("of unknown version");
    const std::string build = machine.text("/proc/sys/kernel/version").value_or("");
    const bool is_real_time = machine.number("/sys/kernel/realtime").value_or(0) == 1 ||
                              build.find("PREEMPT_RT") != std::string::npos;
    const std::string found =
        fmt::format("Linux {}, {}PREEMPT_RT", release, is_real_time ? "" : "not ");
    if (is_real_time || !evidence.purpose.uses_usb) {
        return {Verdict::ok, found};
    }
    const Process &process = evidence.process;
    return {Verdict::warning, found,
            machine.is_container() ? "install a kernel with PREEMPT_RT on the host"
            : machine.is_ubuntu()
                ? process.sudo() + "pro enable realtime-kernel"
                : install_line(machine, process, "linux-image-rt-" + process.architecture) +
                      "  # then restart"};
}

Finding idle_check(const Evidence &evidence) {
    const bool is_short = evidence.probes.rights.idle_is_short;
    const double longest_s = kMaxWaking / evidence.purpose.servo_hz;
    const std::optional<IdleState> deepest = deepest_idle(evidence.machine);
    if (!deepest) {
        return {is_short ? Verdict::ok : Verdict::not_applicable,
                "none are shown, as in a virtual machine or container"};
    }
    const std::string waking =
        fmt::format("{} takes {:.0f} us to leave", deepest->name, 1e6 * deepest->waking_s);
    if (is_short || deepest->waking_s <= longest_s) {
        return {Verdict::ok,
                waking + (is_short ? "; the servo keeps the processors out of it" : "")};
    }
    const std::string sudo = evidence.process.sudo();
    return {Verdict::warning,
            waking + fmt::format(", more than {:.0f} us, a tenth of a tick", 1e6 * longest_s),
            !evidence.machine.exists(kIdleFile)
                ? fmt::format("echo 1 | {}tee {}cpu*/cpuidle/state[1-9]/disable", sudo, kProcessors)
                : fmt::format("echo 'KERNEL==\"cpu_dma_latency\", MODE=\"0666\"' | {0}tee "
                              "/etc/udev/rules.d/99-springdrive.rules && {0}chmod 666 {1}",
                              sudo, kIdleFile)};
}

Finding governor_check(const Evidence &evidence) {
    const Machine &machine = evidence.machine;
    std::size_t known = 0;
    std::size_t others = 0;
    std::string first_other;
    for (const std::string &processor : processors(machine)) {
        const std::string folder = processor + "/cpufreq";
        const auto governor = machine.text(folder + "/scaling_governor");
        if (!governor || governor->empty()) {
            continue;
        }
        ++known;
        if (*governor != "performance" && others++ == 0) {
            first_other = fmt::format("{} ({} to {} MHz)", *governor,
                                      megahertz(machine, folder + "/scaling_min_freq"),
                                      megahertz(machine, folder + "/scaling_max_freq"));
        }
    }
    if (known == 0) {
        return {Verdict::not_applicable,
                "not to be set here, as in a virtual machine or container"};
    }
    if (others == 0) {
        return {Verdict::ok, fmt::format("governor performance on all {}", known)};
    }
    return {Verdict::warning, fmt::format("governor {} on {} of {}", first_other, others, known),
            fmt::format("echo performance | {}tee {}cpu*/cpufreq/scaling_governor",
                        evidence.process.sudo(), kProcessors)};
}

} // namespace springdrive::app::doctor
