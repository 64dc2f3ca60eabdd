#include "app/doctor/doctor_report.h"

#include "base/print.h"
#include "base/quoting.h"

#include <nlohmann/json.hpp>

#include <string>

namespace springdrive::app::doctor {

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

} // namespace

void write_text(std::ostream &out, const DoctorReport &report) {
    print(out, "springdrive {} --device {} at {:.6g} Hz, on {}\n", report.version,
          device_text(report.purpose), report.purpose.servo_hz, report.machine);
    for (const Check &check : report.checks) {
        print(out, "{:<9}{}: {}\n", mark_of(check.verdict), check.title, check.found);
        if (!check.mend.empty()) {
            print(out, "         why: {}\n         do:  {}\n", check.matters, check.mend);
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
                                  {"mend", check.mend}});
    }
    out << json_text(json) << '\n';
}

} // namespace springdrive::app::doctor
