// By what a computer is judged: what the kernel and the system's files say about it, and what this
// process may do on it, both values, so that tests can lay out any other computer; and what can
// only be known by trying: each probe runs in a process of its own, so that a driver that crashes
// or hangs, or a disk that does not answer, ends neither the doctor nor its patience.
#pragma once

#include "device/usb/driver/board_survey.h"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <sys/types.h>
#include <vector>

namespace springdrive::app::doctor {

/// The files of a computer. Whatever they contain, nothing here throws, waits or reads without end.
class Machine {
public:
    /// @param root  the folder that stands for "/"
    explicit Machine(std::filesystem::path root = "/") : root_(std::move(root)) {}

    /// The contents on one line, in printable ASCII; none if it cannot be read or is no file.
    [[nodiscard]] std::optional<std::string> text(std::string_view path) const;
    [[nodiscard]] std::optional<std::int64_t> number(std::string_view path) const;
    /// The lines of a file as they are, at most its first 256 KiB; none if it cannot be read.
    [[nodiscard]] std::vector<std::string> lines(std::string_view path) const;
    [[nodiscard]] bool exists(std::string_view path) const;
    [[nodiscard]] bool is_program(std::string_view path) const;
    /// The names in a folder, sorted, cpu2 before cpu10; none if it cannot be read.
    [[nodiscard]] std::vector<std::string> names_in(std::string_view folder) const;
    /// Where a link points; empty if it is none.
    [[nodiscard]] std::string target_of(std::string_view link) const;

    [[nodiscard]] bool is_container() const;
    [[nodiscard]] bool is_debian() const; ///< or based on it
    [[nodiscard]] bool is_ubuntu() const;

private:
    [[nodiscard]] std::filesystem::path at(std::string_view path) const;
    [[nodiscard]] std::optional<std::string> contents(std::string_view path,
                                                      std::size_t most) const;

    std::filesystem::path root_;
};

/// This process, and who runs it.
struct Process {
    static constexpr std::uint64_t kUnlimited = std::numeric_limits<std::uint64_t>::max();

    unsigned user_id = 0; ///< effective
    std::int64_t parent_id = 0;
    std::vector<unsigned> group_ids;
    std::uint64_t priority_limit = 0; ///< RLIMIT_RTPRIO, soft and hard
    std::uint64_t priority_limit_hard = 0;
    std::uint64_t memory_lock_limit_bytes = 0; ///< RLIMIT_MEMLOCK
    std::uint64_t memory_lock_limit_hard_bytes = 0;
    std::string architecture; ///< as Debian names it
    std::map<std::string, std::string, std::less<>> environment;
    std::filesystem::path setup_folder; ///< of the source tree; may not exist

    /// Of the environment; empty if it is not set.
    [[nodiscard]] std::string variable(std::string_view name) const;
    [[nodiscard]] bool is_root() const { return user_id == 0; }
    /// Before a command that only root may run.
    [[nodiscard]] std::string sudo() const { return is_root() ? "" : "sudo "; }
};

/// @param setup_folder  with the files that repairing lines copy
[[nodiscard]] Process this_process(const std::filesystem::path &setup_folder);

/// The line that installs a package.
[[nodiscard]] std::string install_line(const Machine &machine, const Process &process,
                                       const std::string &package);

/// A word of a shell's command line, in single quotes if it needs them.
[[nodiscard]] std::string shell_word(const std::string &word);

struct Purpose;

/// What the servo's thread is granted.
struct RightsProbe {
    bool has_answered = false;
    int priority = 0;         ///< that was requested
    int priority_refused = 0; ///< an errno; 0: granted
    bool memory_locked = false;
    bool idle_is_short = false;
};

/// A hidden window, as `demo` would open it.
struct PictureProbe {
    bool has_answered = false;
    std::string display_problem; ///< empty: there is a display
    std::string window_problem;  ///< empty: there is a window with OpenGL 3.3
    std::string version;         ///< of OpenGL, also of one that is too old
    std::string renderer;
};

/// Rows of a record, written as fast as the disk takes them.
struct DiskProbe {
    bool has_answered = false;
    int refused = 0; ///< an errno; 0: written and synchronised
    double written_bytes_per_s = 0.0;
    double longest_sync_s = 0.0;
    double free_bytes = 0.0;
};

struct UsbProbe {
    bool has_answered = false;
    std::string problem; ///< of USB as a whole; empty: the list is complete
    std::vector<usb::SurveyedBoard> boards;
};

struct Probes {
    RightsProbe rights;
    PictureProbe picture;
    DiskProbe disk;
    UsbProbe usb;
};

/// Bytes that a record takes each second.
[[nodiscard]] double record_bytes_per_s(double servo_hz);

inline constexpr std::chrono::milliseconds kProbeTime{2300};

/// All probes at once, which takes as long as the slowest, at most kProbeTime. Call while the
/// process has no other thread: it forks.
[[nodiscard]] Probes try_all(const Purpose &purpose);

/// Work in a process of its own that may crash or never end.
/// Used while this process has no other thread: forks.
class ChildAnswer {
public:
    using Clock = std::chrono::steady_clock;

    /// Starts `work`, which sees neither standard input nor the terminal. It ends with this
    /// process.
    explicit ChildAnswer(const std::function<std::string()> &work);
    ~ChildAnswer(); ///< kills the child, without waiting for one that cannot be killed
    ChildAnswer(const ChildAnswer &) = delete;
    ChildAnswer &operator=(const ChildAnswer &) = delete;

    /// What `work` returned; none if it crashed, threw, or has not returned by then.
    [[nodiscard]] std::optional<std::string> by(Clock::time_point deadline);

private:
    pid_t child_ = -1;
    int pipe_ = -1;
};

/// @return 0 once all is written to an open file, or an errno
[[nodiscard]] int write_all(int file, std::string_view bytes);

// The probes of the processes, one by one.

/// Writes for some 0.4 s to a file without a name, which goes with this process.
/// @param second_bytes  of a record: written before each synchronisation
[[nodiscard]] DiskProbe try_disk(const std::filesystem::path &folder, std::size_t second_bytes);

/// Opens a hidden window. For a process of its own: graphics drivers may end it.
[[nodiscard]] PictureProbe try_picture();

} // namespace springdrive::app::doctor
