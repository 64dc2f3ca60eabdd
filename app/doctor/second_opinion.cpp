#include "app/doctor/second_opinion.h"

#include "app/host/child_program.h"
#include "base/input_error.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <system_error>

namespace springdrive::app::doctor {

namespace {

Verdict verdict_named(const std::string &name) {
    const auto *const found = std::ranges::find(kVerdictNames, name);
    if (found == kVerdictNames.end()) {
        throw InputError("springdrive doctor gives a verdict that this program does not know");
    }
    return static_cast<Verdict>(found - kVerdictNames.begin());
}

} // namespace

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
