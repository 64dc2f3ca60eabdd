#include "app/doctor/probe.h"

#include "app/doctor/checks.h"
#include "base/input_error.h"
#include "base/real_time_thread.h"
#include "device/usb/driver/board_port.h"
#include "device/usb/driver/board_survey.h"
#include "engine/record/record_header.h"
#include "engine/servo/real_time.h"

#include <fcntl.h>
#include <nlohmann/json.hpp>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <thread>

// Answers pass between processes as JSON. Both ends are this program, but an answer may be that of
// a process that went wrong: what does not parse is none.
namespace springdrive::usb {
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(SurveyedBoard, bus, address, sysfs_name, serial, speed, firmware,
                                   obstacle, problem)
} // namespace springdrive::usb

namespace springdrive::app::doctor {

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
