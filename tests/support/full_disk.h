// A disk that is full, for files of this process.
#pragma once

#include <csignal>
#include <cstdint>
#include <sys/resource.h>

namespace springdrive::testing {

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

} // namespace springdrive::testing
