// Whether a record can be written as fast as it grows: tried, and judged.
#include "app/doctor/checks.h"

#include <fmt/format.h>

#include <fcntl.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <string>
#include <system_error>
#include <vector>

namespace springdrive::app::doctor {

namespace {

/// A disk that is just fast enough has nothing left for other programs.
constexpr double kAmple = 4.0;
constexpr double kMinRecord_s = 600.0;
constexpr const char *kAnotherDisk = "cd ~  # start springdrive in a folder on another disk";

std::string text_of_bytes(double bytes) {
    return bytes >= 1e9 ? fmt::format("{:.1f} GB", 1e-9 * bytes)
                        : fmt::format("{:.1f} MB", 1e-6 * bytes);
}

std::string text_of_time(double time_s) {
    return time_s >= 5400.0 ? fmt::format("{:.0f} h", time_s / 3600.0)
           : time_s >= 90.0 ? fmt::format("{:.0f} min", time_s / 60.0)
                            : fmt::format("{:.0f} s", time_s);
}

std::string make_room(const std::string &folder) {
    return "du -xh " + folder + " | sort -h | tail  # lists what takes the space";
}

std::string fix_refusal(const Evidence &evidence, const std::string &folder) {
    const std::string sudo = evidence.process.sudo();
    std::error_code unreadable;
    switch (evidence.probes.disk.refused) {
    case ENOENT:
        if (!std::filesystem::exists(evidence.purpose.folder, unreadable)) {
            return "mkdir -p " + folder;
        }
        break; // a folder of the kernel's
    case EACCES:
    case EPERM:
        return folder == "." ? "cd ~  # start springdrive in a folder of your own"
                             : fmt::format("{}chown \"$USER\" {}", sudo, folder);
    case EROFS:
        return fmt::format("{}mount -o remount,rw \"$(findmnt -n -o TARGET --target {})\"", sudo,
                           folder);
    case ENOSPC:
    case EDQUOT:
        return make_room(folder);
    default:
        break;
    }
    return kAnotherDisk;
}

using Clock = std::chrono::steady_clock;

constexpr double kWriting_s = 0.4;
constexpr std::size_t kMax_bytes = std::size_t{64} << 20U;

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

DiskProbe try_disk(const std::filesystem::path &folder, std::size_t second_bytes) {
    DiskProbe probe;
    const int file = create_nameless(folder);
    if (file < 0) {
        probe.refused = errno;
        return probe;
    }
    struct statvfs space {};
    if (fstatvfs(file, &space) == 0) {
        probe.free_bytes =
            static_cast<double>(space.f_bavail) * static_cast<double>(space.f_frsize);
    }
    const std::vector<char> second = noise(second_bytes);
    const Clock::time_point start = Clock::now();
    std::size_t written = 0;
    do {
        probe.refused = write_all(file, {second.data(), second.size()});
        const Clock::time_point wrote = Clock::now();
        if (probe.refused == 0 && fdatasync(file) != 0) {
            probe.refused = errno;
        }
        probe.longest_sync_s = std::max(probe.longest_sync_s, seconds_since(wrote));
        written += second.size();
    } while (probe.refused == 0 && seconds_since(start) < kWriting_s && written < kMax_bytes);
    probe.written_bytes_per_s = static_cast<double>(written) / seconds_since(start);
    close(file);
    return probe;
}

Finding disk_check(const Evidence &evidence) {
    const DiskProbe &probe = evidence.probes.disk;
    const std::string folder = shell_word(evidence.purpose.folder.string());
    const double needed_bytes_per_s = record_bytes_per_s(evidence.purpose.servo_hz);
    const std::string needed = fmt::format("a record needs {:.2f} MB/s at {:.6g} Hz",
                                           1e-6 * needed_bytes_per_s, evidence.purpose.servo_hz);
    if (!probe.has_answered) {
        return {Verdict::failure,
                fmt::format("did not write one second of a record in {:.1f} s; {}",
                            1e-3 * static_cast<double>(kProbeTime.count()), needed),
                kAnotherDisk};
    }
    if (probe.refused != 0) {
        return {Verdict::failure, std::generic_category().message(probe.refused),
                fix_refusal(evidence, folder)};
    }
    const double lasts_s = probe.free_bytes / needed_bytes_per_s;
    const std::string found =
        fmt::format("writes {:.1f} MB/s, synchronised in {:.1f} ms; {}; {} free, which last {}",
                    1e-6 * probe.written_bytes_per_s, 1e3 * probe.longest_sync_s, needed,
                    text_of_bytes(probe.free_bytes), text_of_time(lasts_s));
    if (probe.written_bytes_per_s < kAmple * needed_bytes_per_s) {
        return {probe.written_bytes_per_s < needed_bytes_per_s ? Verdict::failure
                                                               : Verdict::warning,
                found, "cd ~  # start springdrive in a folder on a faster disk"};
    }
    if (lasts_s < kMinRecord_s) {
        return {Verdict::warning, found, make_room(folder)};
    }
    return {Verdict::ok, found};
}

} // namespace springdrive::app::doctor
