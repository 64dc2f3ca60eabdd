// Permissions of files. Tests run as root, for whom they do not hold: so they look at the modes.
#pragma once

#include <filesystem>
#include <sys/stat.h>

namespace springdrive::testing {

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

} // namespace springdrive::testing
