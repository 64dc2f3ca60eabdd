#include "app/doctor/checks.h"

#include <algorithm>
#include <iterator>
#include <sstream>
#include <string>

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

} // namespace springdrive::app::doctor
