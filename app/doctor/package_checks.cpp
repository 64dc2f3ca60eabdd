// What springdrive starts or loads while it runs, beside the libraries without which it does not
// start at all.
#include "app/doctor/checks.h"

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

} // namespace springdrive::app::doctor
