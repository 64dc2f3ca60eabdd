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

Check gnuplot(const Evidence &evidence) {
    Check check{"gnuplot",
                "gnuplot",
                Verdict::ok,
                find_program(evidence, "gnuplot"),
                "figures, chart and stability --out draw with it",
                ""};
    if (check.found.empty()) {
        check.verdict = Verdict::warning;
        check.found = "missing in PATH";
        check.mend = install_line(evidence.machine, evidence.process, "gnuplot-nox");
    }
    return check;
}

Check font(const Evidence &evidence) {
    Check check{"font",
                "font with Greek letters",
                Verdict::ok,
                SPRINGDRIVE_FONT,
                "without it the window shows ? for symbols",
                ""};
    if (!evidence.machine.exists(SPRINGDRIVE_FONT)) {
        check.verdict = evidence.purpose.has_window ? Verdict::warning : Verdict::not_applicable;
        check.found += " is missing";
        check.mend = install_line(evidence.machine, evidence.process, "fonts-dejavu-core");
    }
    return check;
}

} // namespace

std::vector<Check> package_checks(const Evidence &evidence) {
    return {gnuplot(evidence), font(evidence)};
}

} // namespace springdrive::app::doctor
