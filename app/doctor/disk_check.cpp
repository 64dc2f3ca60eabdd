// Whether a record can be written as fast as it grows.
#include "app/doctor/checks.h"

#include <fmt/format.h>

#include <cerrno>
#include <string>
#include <system_error>

namespace springdrive::app::doctor {

namespace {

/// A disk that is just fast enough has nothing left for other programs.
constexpr double kAmple = 4.0;
constexpr double kLeastRecord_s = 600.0;
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

std::string mend_refusal(const Evidence &evidence, const std::string &folder) {
    const std::string sudo = evidence.process.sudo();
    std::error_code unreadable;
    switch (evidence.trials.disk.refused) {
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

} // namespace

Finding disk_check(const Evidence &evidence) {
    const DiskTrial &trial = evidence.trials.disk;
    const std::string folder = shell_word(evidence.purpose.folder.string());
    const double needed_bytes_per_s = record_bytes_per_s(evidence.purpose.servo_hz);
    const std::string needed = fmt::format("a record needs {:.2f} MB/s at {:.6g} Hz",
                                           1e-6 * needed_bytes_per_s, evidence.purpose.servo_hz);
    if (!trial.has_answered) {
        return {Verdict::failure,
                fmt::format("did not write one second of a record in {:.1f} s; {}",
                            1e-3 * static_cast<double>(kTrialTime.count()), needed),
                kAnotherDisk};
    }
    if (trial.refused != 0) {
        return {Verdict::failure, std::generic_category().message(trial.refused),
                mend_refusal(evidence, folder)};
    }
    const double lasts_s = trial.free_bytes / needed_bytes_per_s;
    const std::string found =
        fmt::format("writes {:.1f} MB/s, synchronised in {:.1f} ms; {}; {} free, which last {}",
                    1e-6 * trial.written_bytes_per_s, 1e3 * trial.longest_sync_s, needed,
                    text_of_bytes(trial.free_bytes), text_of_time(lasts_s));
    if (trial.written_bytes_per_s < kAmple * needed_bytes_per_s) {
        return {trial.written_bytes_per_s < needed_bytes_per_s ? Verdict::failure
                                                               : Verdict::warning,
                found, "cd ~  # start springdrive in a folder on a faster disk"};
    }
    if (lasts_s < kLeastRecord_s) {
        return {Verdict::warning, found, make_room(folder)};
    }
    return {Verdict::ok, found};
}

} // namespace springdrive::app::doctor
