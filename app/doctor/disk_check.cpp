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
    return "cd ~  # start springdrive in a folder on another disk";
}

} // namespace

Check disk_check(const Evidence &evidence) {
    const DiskTrial &trial = evidence.trials.disk;
    const std::string folder = shell_word(evidence.purpose.folder.string());
    const double needed_bytes_per_s = record_bytes_per_s(evidence.purpose.servo_hz);
    const std::string needed = fmt::format("a record needs {:.2f} MB/s at {:.6g} Hz",
                                           1e-6 * needed_bytes_per_s, evidence.purpose.servo_hz);
    Check check{"disk",
                "disk for records in " + folder,
                Verdict::ok,
                "",
                "a record ends where the disk is full or too slow",
                ""};
    if (!trial.has_answered) {
        check.verdict = Verdict::failure;
        check.found = fmt::format("did not write one second of a record in {:.1f} s; {}",
                                  1e-3 * static_cast<double>(kTrialTime.count()), needed);
        check.mend = "cd ~  # start springdrive in a folder on another disk";
        return check;
    }
    if (trial.refused != 0) {
        check.verdict = Verdict::failure;
        check.found = std::generic_category().message(trial.refused);
        check.mend = mend_refusal(evidence, folder);
        return check;
    }
    const double lasts_s = trial.free_bytes / needed_bytes_per_s;
    check.found =
        fmt::format("writes {:.1f} MB/s, synchronised in {:.1f} ms; {}; {} free, which last {}",
                    1e-6 * trial.written_bytes_per_s, 1e3 * trial.longest_sync_s, needed,
                    text_of_bytes(trial.free_bytes), text_of_time(lasts_s));
    if (trial.written_bytes_per_s < kAmple * needed_bytes_per_s) {
        check.verdict =
            trial.written_bytes_per_s < needed_bytes_per_s ? Verdict::failure : Verdict::warning;
        check.mend = "cd ~  # start springdrive in a folder on a faster disk";
    } else if (lasts_s < kLeastRecord_s) {
        check.verdict = Verdict::warning;
        check.mend = make_room(folder);
    }
    return check;
}

} // namespace springdrive::app::doctor
