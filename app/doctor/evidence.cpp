#include "app/doctor/evidence.h"

#include "app/doctor/checks.h"
#include "base/input_error.h"
#include "base/real_time_thread.h"
#include "base/text.h"
#include "device/usb/driver/board_port.h"
#include "device/usb/driver/board_survey.h"
#include "engine/record/record_format.h"
#include "engine/servo/real_time.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/utsname.h>
#include <sys/wait.h>
#include <system_error>
#include <thread>
#include <unistd.h>

// Answers pass between processes as JSON. Both ends are this program, but an answer may be that of
// a process that went wrong: what does not parse is none.
namespace springdrive::usb {
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(SurveyedBoard, bus, address, sysfs_name, serial, speed, firmware,
                                   obstacle, problem)
} // namespace springdrive::usb

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

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(RightsProbe, has_answered, priority, priority_refused,
                                   memory_locked, idle_is_short)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(PictureProbe, has_answered, display_problem, window_problem,
                                   version, renderer)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(DiskProbe, has_answered, refused, written_bytes_per_s,
                                   longest_sync_s, free_bytes)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(UsbProbe, has_answered, problem, boards)

namespace {

constexpr char kEnd = '\0'; ///< after a complete answer

/// Drivers print to both streams, which belong to the doctor's report.
void close_streams() {
    const int nothing = open("/dev/null", O_RDWR | O_CLOEXEC);
    for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
        dup2(nothing, stream);
    }
}

[[noreturn]] void answer_and_end(int pipe, const std::function<std::string()> &work) noexcept {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    close_streams();
    try {
        static_cast<void>(write_all(pipe, work() + kEnd));
    } catch (...) { // which answers nothing
        _exit(1);
    }
    _exit(0);
}

/// The priority last, and on a thread that ends at once: with it, this process could hold up a
/// servo that is running.
RightsProbe try_rights(int priority) {
    RightsProbe probe;
    const servo::ShortIdle short_idle;
    probe.idle_is_short = short_idle.warning().empty();
    probe.priority = priority;
    probe.memory_locked = servo::request_locked_memory();
    std::thread([&] { probe.priority_refused = request_priority(priority); }).join();
    return probe;
}

UsbProbe try_usb() {
    UsbProbe probe;
    try {
        probe.boards = usb::survey_boards();
    } catch (const InputError &error) {
        probe.problem = error.what();
    }
    return probe;
}

/// In a process of its own, from now on.
template <typename Probe> class Asked {
public:
    explicit Asked(const std::function<Probe()> &work)
        : child_([&work] {
              Probe probe = work();
              probe.has_answered = true;
              return nlohmann::json(probe).dump(-1, ' ', true,
                                                nlohmann::json::error_handler_t::replace);
          }) {}

    [[nodiscard]] Probe by(ChildAnswer::Clock::time_point deadline) {
        const std::optional<std::string> answer = child_.by(deadline);
        try {
            return answer ? nlohmann::json::parse(*answer).get<Probe>() : Probe();
        } catch (const nlohmann::json::exception &) {
            return {};
        }
    }

private:
    ChildAnswer child_;
};

} // namespace

ChildAnswer::ChildAnswer(const std::function<std::string()> &work) {
    std::array<int, 2> ends{-1, -1};
    if (pipe2(ends.data(), O_CLOEXEC) != 0) {
        return;
    }
    child_ = fork();
    if (child_ == 0) {
        close(ends[0]);
        answer_and_end(ends[1], work);
    }
    close(ends[1]);
    pipe_ = ends[0];
}

ChildAnswer::~ChildAnswer() {
    if (child_ > 0) {
        kill(child_, SIGKILL);
        // One that waits for a dead disk remains until the disk answers, or this process ends.
        waitpid(child_, nullptr, WNOHANG);
    }
    if (pipe_ >= 0) {
        close(pipe_);
    }
}

std::optional<std::string> ChildAnswer::by(Clock::time_point deadline) {
    std::string answer;
    while (pipe_ >= 0) {
        const auto left =
            std::chrono::ceil<std::chrono::milliseconds>(deadline - Clock::now()).count();
        pollfd waits{pipe_, POLLIN, 0};
        const int ready = poll(&waits, 1, static_cast<int>(std::max<std::int64_t>(0, left)));
        if (ready < 0 && errno == EINTR) {
            continue;
        }
        std::array<char, 4096> block{};
        const ssize_t count = ready > 0 ? read(pipe_, block.data(), block.size()) : 0;
        if (count <= 0) {
            break;
        }
        answer.append(block.data(), static_cast<std::size_t>(count));
        if (answer.back() == kEnd) {
            answer.pop_back();
            return answer;
        }
    }
    return std::nullopt;
}

int write_all(int file, std::string_view bytes) {
    while (!bytes.empty()) {
        const ssize_t count = write(file, bytes.data(), bytes.size());
        if (count < 0 && errno != EINTR) {
            return errno;
        }
        if (count == 0) {
            return EIO;
        }
        bytes.remove_prefix(static_cast<std::size_t>(std::max<ssize_t>(0, count)));
    }
    return 0;
}

double record_bytes_per_s(double servo_hz) {
    return record::record_header(servo_hz).row_bytes * servo_hz;
}

Probes try_all(const Purpose &purpose) {
    const auto deadline = ChildAnswer::Clock::now() + kProbeTime;
    const int priority = purpose.uses_usb ? usb::kPortThreadPriority : servo::kServoPriority;
    const auto second_bytes = static_cast<std::size_t>(record_bytes_per_s(purpose.servo_hz));
    Asked<UsbProbe> usb(try_usb);
    Asked<PictureProbe> picture(try_picture);
    Asked<DiskProbe> disk([&] { return try_disk(purpose.folder, second_bytes); });
    // Last: with its priority it could hold up the others on a computer with one processor.
    Asked<RightsProbe> rights([&] { return try_rights(priority); });
    Probes probes;
    probes.rights = rights.by(deadline);
    probes.disk = disk.by(deadline);
    probes.picture = picture.by(deadline);
    probes.usb = usb.by(deadline);
    return probes;
}

} // namespace springdrive::app::doctor
