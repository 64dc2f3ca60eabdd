#include "app/doctor/machine.h"

#include "base/text.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <cstring>
#include <system_error>

namespace springdrive::app::doctor {

namespace {

constexpr std::size_t kShortFile_bytes = 4096; ///< as a file of sysfs
constexpr std::size_t kLongFile_bytes = std::size_t{256} * 1024;
constexpr std::size_t kMaxNames = 100'000;

/// Digits count as one number: cpu2 is before cpu10.
bool is_before(const std::string &a, const std::string &b) {
    return strverscmp(a.c_str(), b.c_str()) < 0;
}

void take_limit(int resource, std::uint64_t &soft, std::uint64_t &hard) {
    const auto of = [](rlim_t limit) {
        return limit == RLIM_INFINITY ? Process::kUnlimited : static_cast<std::uint64_t>(limit);
    };
    rlimit limit{};
    if (getrlimit(static_cast<__rlimit_resource_t>(resource), &limit) == 0) {
        soft = of(limit.rlim_cur);
        hard = of(limit.rlim_max);
    }
}

std::string debian_architecture() {
    utsname names{};
    uname(&names);
    const std::string machine = static_cast<const char *>(names.machine);
    return machine == "x86_64" ? "amd64" : machine == "aarch64" ? "arm64" : machine;
}

} // namespace

std::filesystem::path Machine::at(std::string_view path) const {
    return root_ / std::filesystem::path(path).relative_path();
}

/// Opening a pipe or a device could wait or have an effect: only regular files are read.
std::optional<std::string> Machine::contents(std::string_view path, std::size_t most) const {
    const int file = open(at(path).c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC | O_NOCTTY);
    if (file < 0) {
        return std::nullopt;
    }
    struct stat status {};
    std::optional<std::string> text;
    if (fstat(file, &status) == 0 && S_ISREG(status.st_mode)) {
        text.emplace(most, '\0');
        std::size_t size = 0;
        ssize_t count = 0;
        while (size < most && (count = read(file, text->data() + size, most - size)) > 0) {
            size += static_cast<std::size_t>(count);
        }
        text->resize(size);
        if (count < 0) {
            text.reset();
        }
    }
    close(file);
    return text;
}

std::optional<std::string> Machine::text(std::string_view path) const {
    std::optional<std::string> text = contents(path, kShortFile_bytes);
    if (text) {
        text = one_line(*text);
        const auto is_foreign = [](char c) { return static_cast<unsigned char>(c) >= 0x80; };
        std::ranges::replace_if(*text, is_foreign, '?');
    }
    return text;
}

std::optional<std::int64_t> Machine::number(std::string_view path) const {
    const std::optional<std::string> written = text(path);
    return written ? number_in<std::int64_t>(*written) : std::nullopt;
}

std::vector<std::string> Machine::lines(std::string_view path) const {
    std::vector<std::string> all;
    const std::optional<std::string> text = contents(path, kLongFile_bytes);
    std::string_view rest = text ? std::string_view(*text) : std::string_view();
    while (!rest.empty()) {
        const std::size_t end = std::min(rest.find('\n'), rest.size());
        all.emplace_back(rest.substr(0, end));
        rest.remove_prefix(std::min(end + 1, rest.size()));
    }
    return all;
}

bool Machine::exists(std::string_view path) const {
    std::error_code unreadable;
    return std::filesystem::exists(at(path), unreadable);
}

bool Machine::is_program(std::string_view path) const {
    std::error_code unreadable;
    const auto status = std::filesystem::status(at(path), unreadable);
    using std::filesystem::perms;
    return !unreadable && std::filesystem::is_regular_file(status) &&
           (status.permissions() & (perms::owner_exec | perms::group_exec | perms::others_exec)) !=
               perms::none;
}

std::vector<std::string> Machine::names_in(std::string_view folder) const {
    std::vector<std::string> names;
    std::error_code ends;
    auto entry = std::filesystem::directory_iterator(at(folder), ends);
    while (!ends && entry != std::filesystem::directory_iterator() && names.size() < kMaxNames) {
        names.push_back(entry->path().filename().string());
        entry.increment(ends);
    }
    std::ranges::sort(names, is_before);
    return names;
}

std::string Machine::target_of(std::string_view link) const {
    std::error_code unreadable;
    return std::filesystem::read_symlink(at(link), unreadable).string();
}

bool Machine::is_container() const {
    return exists("/.dockerenv") || exists("/run/.containerenv") ||
           exists("/run/systemd/container");
}

bool Machine::is_debian() const {
    return is_ubuntu() || std::ranges::any_of(lines("/etc/os-release"), [](const auto &line) {
               return line.starts_with("ID") && line.find("debian") != std::string::npos;
           });
}

bool Machine::is_ubuntu() const {
    return std::ranges::any_of(lines("/etc/os-release"), [](const auto &line) {
        return line.starts_with("ID") && line.find("ubuntu") != std::string::npos;
    });
}

std::string Process::variable(std::string_view name) const {
    const auto found = environment.find(name);
    return found == environment.end() ? std::string() : found->second;
}

Process this_process(const std::filesystem::path &setup_folder) {
    Process process;
    process.user_id = geteuid();
    process.parent_id = getppid();
    process.group_ids.resize(static_cast<std::size_t>(std::max(0, getgroups(0, nullptr))));
    if (getgroups(static_cast<int>(process.group_ids.size()), process.group_ids.data()) < 0) {
        process.group_ids.clear();
    }
    process.group_ids.push_back(getegid()); // may be missing in the list
    take_limit(RLIMIT_RTPRIO, process.priority_limit, process.priority_limit_hard);
    take_limit(RLIMIT_MEMLOCK, process.memory_lock_limit_bytes,
               process.memory_lock_limit_hard_bytes);
    process.architecture = debian_architecture();
    for (char **variable = environ; *variable != nullptr; ++variable) {
        const std::string_view text = *variable;
        const std::size_t sign = std::min(text.find('='), text.size());
        process.environment.emplace(text.substr(0, sign),
                                    text.substr(std::min(sign + 1, text.size())));
    }
    process.setup_folder = setup_folder;
    return process;
}

std::string install_line(const Machine &machine, const Process &process,
                         const std::string &package) {
    return machine.is_debian() ? process.sudo() + "apt-get install " + package
                               : "install what Debian calls " + package;
}

std::string shell_word(const std::string &word) {
    const auto is_plain = [](char c) {
        return std::isalnum(static_cast<unsigned char>(c)) != 0 ||
               std::string_view("/._-+:,@%").find(c) != std::string_view::npos;
    };
    if (!word.empty() && word.front() != '-' && std::ranges::all_of(word, is_plain)) {
        return word;
    }
    std::string quoted = "'";
    for (const char c : word) {
        quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
    }
    return quoted + "'";
}

} // namespace springdrive::app::doctor
