// Temporary files of tests, and what may stand in their way: a full disk, missing rights. Tests run
// as root, for whom permissions do not hold: so they look at the modes, or continue in a process
// that has no rights.
#pragma once

#include <csignal>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <sys/resource.h>
#include <sys/stat.h>

namespace springdrive::testing {

/// An empty folder for one test. It is removed when the process ends, unless a test failed.
[[nodiscard]] std::filesystem::path fresh_folder(const std::string &name);

[[nodiscard]] std::string contents_of(const std::filesystem::path &file);

/// Files of this process cannot grow beyond `bytes` while this lives, as on a full disk.
class FullDisk {
public:
    explicit FullDisk(std::uint64_t bytes) {
        before_ = std::signal(SIGXFSZ, SIG_IGN);
        getrlimit(RLIMIT_FSIZE, &limit_);
        rlimit small = limit_;
        small.rlim_cur = bytes;
        setrlimit(RLIMIT_FSIZE, &small);
    }
    ~FullDisk() {
        setrlimit(RLIMIT_FSIZE, &limit_);
        std::signal(SIGXFSZ, before_);
    }
    FullDisk(const FullDisk &) = delete;
    FullDisk &operator=(const FullDisk &) = delete;

private:
    rlimit limit_{};
    void (*before_)(int) = nullptr;
};

/// The umask of this process, for as long as it lives.
class Umask {
public:
    explicit Umask(mode_t mask) : before_(umask(mask)) {}
    ~Umask() { umask(before_); }
    Umask(const Umask &) = delete;
    Umask &operator=(const Umask &) = delete;

private:
    mode_t before_;
};

/// Such as 0600.
inline unsigned mode_of(const std::filesystem::path &file) {
    return static_cast<unsigned>(std::filesystem::symlink_status(file).permissions());
}

/// What `step` says in a process of its own, which is prepared for it.
[[nodiscard]] std::string said_in_child(const std::function<void()> &prepare,
                                        const std::function<std::string()> &step);

/// Permissions do not apply to root: a child continues as nobody.
void drop_rights();

} // namespace springdrive::testing
