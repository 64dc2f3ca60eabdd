#include "app/doctor/checks.h"

#include "app/host/process.h"
#include "base/input_error.h"
#include "base/print.h"
#include "base/quoting.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <iterator>
#include <sstream>
#include <string>
#include <system_error>

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

} // namespace springdrive::app::doctor
