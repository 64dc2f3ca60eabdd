// What a limit forbids the servo, and how to lift it.
#include "app/doctor/checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstring>
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
    const auto wanted = static_cast<std::uint64_t>(evidence.probes.rights.priority);
    if (process.priority_limit < wanted && process.priority_limit_hard >= wanted) {
        return fmt::format("ulimit -S -r {}", wanted);
    }
    if (evidence.machine.is_container()) {
        return allow(evidence, "rtprio");
    }
    const bool has_right = process.is_root() || process.priority_limit >= wanted;
    if (const std::string file = file_of_missing_share(evidence.machine);
        has_right && !file.empty()) {
        return fmt::format("echo 500000 | {}tee {}", process.sudo(), shell_word(file));
    }
    if (process.priority_limit >= wanted) {
        // The kernel schedules by groups and shows no file for it, as with cgroup v2.
        return process.sudo() + "sysctl -w kernel.sched_rt_runtime_us=-1";
    }
    return allow(evidence, "rtprio");
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

} // namespace springdrive::app::doctor
