#include "app/doctor/checks.h"

#include "app/host/process.h"
#include "base/input_error.h"
#include "base/print.h"
#include "base/text.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <fcntl.h>
#include <iterator>
#include <sstream>
#include <string>
#include <sys/statvfs.h>
#include <system_error>
#include <unistd.h>
#include <vector>

namespace springdrive::app::doctor {

namespace {

/// As the system looks for a program. Empty if there is none.
std::string find_program(const Evidence &evidence, const std::string &name) {
    std::istringstream folders(evidence.process.variable("PATH"));
    for (std::string folder; std::getline(folders, folder, ':');) {
        const std::string file = folder + "/" + name;
        if (folder.starts_with("/") && evidence.machine.is_program(file)) {
            return file;
        }
    }
    return "";
}

} // namespace

Finding gnuplot_check(const Evidence &evidence) {
    const std::string program = find_program(evidence, "gnuplot");
    return !program.empty()
               ? Finding{Verdict::ok, program}
               : Finding{Verdict::warning, "missing in PATH",
                         install_line(evidence.machine, evidence.process, "gnuplot-nox")};
}

Finding font_check(const Evidence &evidence) {
    if (evidence.machine.exists(SPRINGDRIVE_FONT)) {
        return {Verdict::ok, SPRINGDRIVE_FONT};
    }
    return {evidence.purpose.has_window ? Verdict::warning : Verdict::not_applicable,
            std::string(SPRINGDRIVE_FONT) + " is missing",
            install_line(evidence.machine, evidence.process, "fonts-dejavu-core")};
}

std::vector<Check> all_checks(const Evidence &evidence) {
    const std::string disk = "disk for records in " + shell_word(evidence.purpose.folder.string());
    std::vector<Check> all{
        {priority_check(evidence), "rt_priority", "real-time priority",
         "without it ticks come late while the computer is busy"},
        {memory_lock_check(evidence), "memory_lock", "memory lock",
         "without it a tick may wait for memory that was paged out"},
        {real_time_share_check(evidence), "rt_share", "share for real-time threads",
         "beyond it the kernel suspends the servo"},
        {preemption_check(evidence), "preemption", "kernel",
         "without PREEMPT_RT, drivers may hold up a tick"},
        {idle_check(evidence), "idle", "idle states of the processors",
         "a tick starts late by the time that waking up takes"},
        {governor_check(evidence), "governor", "frequency of the processors",
         "a tick takes longer on a processor that was slowed down"},
    };
    std::ranges::move(usb_checks(evidence), std::back_inserter(all));
    all.insert(
        all.end(),
        {{display_check(evidence), "display", "display",
          "only the window (demo) needs it; all other commands do without"},
         {opengl_check(evidence), "opengl", "OpenGL", "the window draws with OpenGL 3.3"},
         {disk_check(evidence), "disk", disk, "a record ends where the disk is full or too slow"},
         {gnuplot_check(evidence), "gnuplot", "gnuplot",
          "figures, chart and stability --out draw with it"},
         {font_check(evidence), "font", "font with Greek letters",
          "without it the window shows ? for symbols"}});
    return all;
}

namespace {

using Json = nlohmann::ordered_json;

std::string device_text(const Purpose &purpose) {
    return !purpose.uses_usb ? "sim" : purpose.serial.empty() ? "usb" : "usb:" + purpose.serial;
}

std::string_view mark_of(Verdict verdict) {
    constexpr std::array<std::string_view, 4> kMarks{"ok", "warning", "FAILURE", "-"};
    return kMarks.at(static_cast<std::size_t>(verdict));
}

std::string count_text(std::size_t count, const char *what) {
    return std::to_string(count) + " " + what + (count == 1 ? "" : "s");
}

Verdict verdict_named(const std::string &name) {
    const auto *const found = std::ranges::find(kVerdictNames, name);
    if (found == kVerdictNames.end()) {
        throw InputError("springdrive doctor gives a verdict that this program does not know");
    }
    return static_cast<Verdict>(found - kVerdictNames.begin());
}

} // namespace

void write_text(std::ostream &out, const DoctorReport &report) {
    print(out, "springdrive {} --device {} at {:.6g} Hz, on {}\n", report.version,
          device_text(report.purpose), report.purpose.servo_hz, report.machine);
    for (const Check &check : report.checks) {
        print(out, "{:<9}{}: {}\n", mark_of(check.verdict), check.title, check.found);
        if (!check.fix.empty()) {
            print(out, "         why: {}\n         do:  {}\n", check.matters, check.fix);
        }
    }
    const std::size_t failures = count_of(report.checks, Verdict::failure);
    const std::size_t warnings = count_of(report.checks, Verdict::warning);
    print(out, "{}, {}\n", count_text(failures, "failure"), count_text(warnings, "warning"));
}

void write_json(std::ostream &out, const DoctorReport &report) {
    Json json;
    json["version"] = report.version;
    json["machine"] = report.machine;
    json["device"] = device_text(report.purpose);
    json["servo_hz"] = report.purpose.servo_hz;
    json["folder"] = report.purpose.folder.string();
    json["failures"] = count_of(report.checks, Verdict::failure);
    json["warnings"] = count_of(report.checks, Verdict::warning);
    json["checks"] = Json::array();
    for (const Check &check : report.checks) {
        json["checks"].push_back({{"id", check.id},
                                  {"title", check.title},
                                  {"verdict", name_of(check.verdict)},
                                  {"found", check.found},
                                  {"matters", check.matters},
                                  {"mend", check.fix}});
    }
    out << json_text(json) << '\n';
}

std::vector<Check> checks_in(std::string_view json) {
    std::vector<Check> checks;
    try {
        const nlohmann::json report = nlohmann::json::parse(json);
        for (const auto &check : report.at("checks")) {
            checks.push_back(
                {{verdict_named(check.at("verdict")), check.at("found"), check.at("mend")},
                 check.at("id"),
                 check.at("title"),
                 check.at("matters")});
        }
    } catch (const nlohmann::json::exception &) {
        throw InputError("springdrive doctor gave no report; run it in a terminal");
    }
    return checks;
}

std::vector<Check> ask_doctor(const std::string &device, double servo_hz) {
    const ProgramEnding ending =
        run_program({"/proc/self/exe", "doctor", "--json", "--device", device, "--servo-hz",
                     fmt::format("{:.17g}", servo_hz)},
                    ".", ProgramStream::output);
    if (ending.spawn_error != 0) {
        throw InputError("springdrive doctor cannot be started: " +
                         std::generic_category().message(ending.spawn_error));
    }
    return checks_in(ending.text);
}

// Whether a record can be written as fast as it grows: tried, and judged.

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
