// What stands between the servo's thread and real time: what a limit forbids it and how to lift
// that; then how the kernel treats it, by share, preemption, idle states and frequency.
#include "app/doctor/checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <sstream>
#include <string>
#include <system_error>

namespace springdrive::app::doctor {

namespace {

constexpr const char *kGroup = "springdrive"; ///< of setup/limits.conf
constexpr const char *kLimitsFile = "/etc/security/limits.d/springdrive.conf";

std::vector<std::string> parts_of(const std::string &line, char separator) {
    std::vector<std::string> parts;
    std::istringstream stream(line);
    for (std::string part; std::getline(stream, part, separator);) {
        parts.push_back(part);
    }
    return parts;
}

std::string user_name(const Evidence &evidence) {
    const std::string id = std::to_string(evidence.process.user_id);
    for (const std::string &line : evidence.machine.lines("/etc/passwd")) {
        const std::vector<std::string> parts = parts_of(line, ':');
        if (parts.size() > 2 && parts[2] == id) {
            return parts[0];
        }
    }
    return "";
}

struct Membership {
    bool group_exists = false;
    bool in_session = false; ///< of this process
    bool in_file = false;    ///< from the next login on
};

Membership membership(const Evidence &evidence, const std::string &group) {
    const std::string user = user_name(evidence);
    for (const std::string &line : evidence.machine.lines("/etc/group")) {
        const std::vector<std::string> parts = parts_of(line, ':');
        if (parts.size() < 3 || parts[0] != group) {
            continue;
        }
        const auto is_this = [&](unsigned id) { return std::to_string(id) == parts[2]; };
        const std::vector<std::string> names =
            parts_of(parts.size() > 3 ? parts[3] : std::string(), ',');
        return {true, std::ranges::any_of(evidence.process.group_ids, is_this),
                !user.empty() && std::ranges::find(names, user) != names.end()};
    }
    return {};
}

/// To whom the system's limits files give `item`.
struct Granted {
    bool to_group = false; ///< kGroup
    bool to_user = false;  ///< by name, or to everyone
};

void add_grants(const Evidence &evidence, const std::string &file, const std::string &item,
                Granted &granted) {
    const std::string user = user_name(evidence);
    for (const std::string &line : evidence.machine.lines(file)) {
        std::istringstream words(line.substr(0, line.find('#')));
        std::string domain;
        std::string type;
        std::string what;
        words >> domain >> type >> what;
        if (what == item) {
            granted.to_group = granted.to_group || domain == std::string("@") + kGroup;
            granted.to_user = granted.to_user || domain == "*" || (domain == user && !user.empty());
        }
    }
}

Granted granted_by_files(const Evidence &evidence, const std::string &item) {
    Granted granted;
    add_grants(evidence, "/etc/security/limits.conf", item, granted);
    for (const std::string &name : evidence.machine.names_in("/etc/security/limits.d")) {
        if (name.ends_with(".conf")) {
            add_grants(evidence, "/etc/security/limits.d/" + name, item, granted);
        }
    }
    return granted;
}

std::string install_limits(const Process &process) {
    const std::filesystem::path file = process.setup_folder / "limits.conf";
    std::error_code unreadable;
    if (std::filesystem::is_regular_file(file, unreadable)) {
        return process.sudo() + "cp " + shell_word(file.string()) + " " + kLimitsFile;
    }
    return fmt::format("printf '@{0} - %s\\n' 'rtprio 90' 'memlock unlimited' | {1}tee {2}", kGroup,
                       process.sudo(), kLimitsFile);
}

/// Among the controllers of a line of /proc/self/cgroup.
bool names_cpu(const std::string &controllers) {
    const std::vector<std::string> names = parts_of(controllers, ',');
    return std::ranges::find(names, "cpu") != names.end();
}

/// The file with the share of real-time scheduling of this process's control group, if the kernel
/// schedules by groups (cgroup v1 with RT_GROUP_SCHED) and the group has none; else empty.
std::string file_of_missing_share(const Machine &machine) {
    for (const std::string &line : machine.lines("/proc/self/cgroup")) {
        const std::vector<std::string> parts = parts_of(line, ':'); // 1:cpu,cpuacct:/group
        if (parts.size() < 3 || !names_cpu(parts[1])) {
            continue;
        }
        const std::string controller = "/sys/fs/cgroup/" + parts[1];
        // A container sees its own group as the topmost.
        for (const std::string &group : {parts[2], std::string()}) {
            const std::string file = controller + group + "/cpu.rt_runtime_us";
            if (const auto share_us = machine.number(file)) {
                return *share_us == 0 ? file : "";
            }
        }
    }
    return "";
}

/// One line lifts both limits.
std::string allow(const Evidence &evidence, const std::string &item) {
    if (evidence.machine.is_container()) {
        const bool has_share = file_of_missing_share(evidence.machine).empty();
        return fmt::format(
            "start the container with --cap-add SYS_NICE{} --ulimit rtprio=90 --ulimit memlock=-1",
            has_share ? "" : " --cpu-rt-runtime=500000");
    }
    if (evidence.process.is_root()) {
        return "start it with all of root's capabilities: these were taken away";
    }
    const Granted granted = granted_by_files(evidence, item);
    if (granted.to_user) {
        return "log in again: limits apply from a login on";
    }
    const Membership member = membership(evidence, kGroup);
    std::string line;
    if (!granted.to_group) {
        line = install_limits(evidence.process);
    }
    if (!member.group_exists) {
        line += (line.empty() ? "" : " && ") + evidence.process.sudo() +
                fmt::format("groupadd --system {}", kGroup);
    }
    if (!member.in_session && !member.in_file) {
        line += (line.empty() ? "" : " && ") + evidence.process.sudo() +
                fmt::format("usermod -aG {} \"$USER\"", kGroup);
    }
    return line.empty() ? "log in again: limits and groups apply from a login on"
                        : line + "  # then log in again";
}

std::string limit_text(std::uint64_t limit) {
    return limit == Process::kUnlimited ? "unlimited" : std::to_string(limit);
}

std::string why_no_priority(const Evidence &evidence) {
    const Process &process = evidence.process;
    const auto requested = static_cast<std::uint64_t>(evidence.probes.rights.priority);
    if (process.priority_limit < requested && process.priority_limit_hard >= requested) {
        return fmt::format("ulimit -S -r {}", requested);
    }
    if (evidence.machine.is_container()) {
        return allow(evidence, "rtprio");
    }
    const bool has_right = process.is_root() || process.priority_limit >= requested;
    if (const std::string file = file_of_missing_share(evidence.machine);
        has_right && !file.empty()) {
        return fmt::format("echo 500000 | {}tee {}", process.sudo(), shell_word(file));
    }
    if (process.priority_limit >= requested) {
        // The kernel schedules by groups and shows no file for it, as with cgroup v2.
        return process.sudo() + "sysctl -w kernel.sched_rt_runtime_us=-1";
    }
    return allow(evidence, "rtprio");
}

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

Finding priority_check(const Evidence &evidence) {
    const RightsProbe &probe = evidence.probes.rights;
    const Verdict wrong = evidence.purpose.worse_with_usb();
    if (!probe.has_answered) {
        return {wrong, "the trial of it did not end: this computer is too busy",
                "end what is busy (see top), and repeat springdrive doctor"};
    }
    if (probe.priority_refused == 0) {
        return {Verdict::ok, fmt::format("SCHED_FIFO {} granted", probe.priority)};
    }
    const bool has_share = file_of_missing_share(evidence.machine).empty();
    return {
        wrong,
        fmt::format("SCHED_FIFO {} refused: {}; the limit is {} (ulimit -r){}", probe.priority,
                    std::generic_category().message(probe.priority_refused),
                    limit_text(evidence.process.priority_limit),
                    has_share ? "" : "; its control group has no share of real-time scheduling"),
        why_no_priority(evidence)};
}

Finding memory_lock_check(const Evidence &evidence) {
    const Process &process = evidence.process;
    if (evidence.probes.rights.memory_locked) {
        return {Verdict::ok, "all memory may be kept in RAM"};
    }
    const std::uint64_t limit = process.memory_lock_limit_bytes;
    const bool may_raise =
        process.memory_lock_limit_hard_bytes == Process::kUnlimited && limit != Process::kUnlimited;
    return {evidence.purpose.worse_with_usb(),
            limit == Process::kUnlimited
                ? "refused"
                : fmt::format("refused: the limit is {} kB (ulimit -l)", limit / 1024),
            may_raise ? "ulimit -S -l unlimited" : allow(evidence, "memlock")};
}

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
