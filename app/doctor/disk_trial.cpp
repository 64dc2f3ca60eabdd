#include "app/doctor/trial.h"

#include <fcntl.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <string>
#include <vector>

namespace springdrive::app::doctor {

namespace {

using Clock = std::chrono::steady_clock;

constexpr double kWriting_s = 0.4;
constexpr std::size_t kMost_bytes = std::size_t{64} << 20U;

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Its name is removed at once, so that nothing stays behind however this process ends.
int create_nameless(const std::filesystem::path &folder) {
    std::string name = folder / ".springdrive_XXXXXX";
    const int file = mkostemp(name.data(), O_CLOEXEC);
    if (file >= 0) {
        unlink(name.c_str());
    }
    return file;
}

/// @return 0, or an errno
int write_all(int file, const std::vector<char> &bytes) {
    for (std::size_t done = 0; done < bytes.size();) {
        const ssize_t count = write(file, bytes.data() + done, bytes.size() - done);
        if (count < 0 && errno != EINTR) {
            return errno;
        }
        if (count == 0) {
            return EIO;
        }
        done += static_cast<std::size_t>(std::max<ssize_t>(0, count));
    }
    return 0;
}

/// Not zeros, which some disks do not store.
std::vector<char> noise(std::size_t size) {
    std::vector<char> bytes(size);
    std::uint32_t state = 1;
    for (char &byte : bytes) {
        state = state * 1'664'525U + 1'013'904'223U;
        byte = static_cast<char>(state >> 24U);
    }
    return bytes;
}

} // namespace

DiskTrial try_disk(const std::filesystem::path &folder, std::size_t second_bytes) {
    DiskTrial trial;
    const int file = create_nameless(folder);
    if (file < 0) {
        trial.refused = errno;
        return trial;
    }
    struct statvfs space {};
    if (fstatvfs(file, &space) == 0) {
        trial.free_bytes =
            static_cast<double>(space.f_bavail) * static_cast<double>(space.f_frsize);
    }
    const std::vector<char> second = noise(second_bytes);
    const Clock::time_point start = Clock::now();
    std::size_t written = 0;
    do {
        trial.refused = write_all(file, second);
        const Clock::time_point wrote = Clock::now();
        if (trial.refused == 0 && fdatasync(file) != 0) {
            trial.refused = errno;
        }
        trial.longest_sync_s = std::max(trial.longest_sync_s, seconds_since(wrote));
        written += second.size();
    } while (trial.refused == 0 && seconds_since(start) < kWriting_s && written < kMost_bytes);
    trial.written_bytes_per_s = static_cast<double>(written) / seconds_since(start);
    close(file);
    return trial;
}

} // namespace springdrive::app::doctor
