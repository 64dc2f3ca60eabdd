#include "app/commands/command.h"

#include "app/commands/common_options.h"
#include "app/doctor/checks.h"
#include "app/host/folders.h"
#include "base/input_error.h"
#include "base/timing.h"
#include "engine/servo/servo.h"

#include <cstdlib>
#include <iostream>
#include <memory>
#include <string>

namespace springdrive::app {

namespace {

struct TypedDoctor {
    doctor::Purpose purpose;
    std::string device = "sim";
    bool no_window = false;
    bool json = false;
};

void run(const TypedDoctor &typed) {
    doctor::DoctorReport report;
    report.version = SPRINGDRIVE_VERSION;
    report.machine = machine_name();
    report.purpose = typed.purpose;
    report.purpose.has_window = !typed.no_window;
    const NamedDevice device = device_named(typed.device);
    report.purpose.uses_usb = device.kind == factory::DeviceKind::usb;
    report.purpose.serial = device.serial;
    report.checks = doctor::all_checks(
        {doctor::Machine(), doctor::this_process((asset_folder() / "../setup").lexically_normal()),
         report.purpose, doctor::try_all(report.purpose)});
    if (typed.json) {
        doctor::write_json(std::cout, report);
    } else {
        doctor::write_text(std::cout, report);
    }
    if (!report.is_healthy()) {
        end_with_status(1);
    }
}

} // namespace

void add_doctor_command(Command &app) {
    Command doctor = app.add_subcommand(
        "doctor", "what this computer allows and lacks, each with the line that mends it");
    const auto typed = std::make_shared<TypedDoctor>();
    // A mistyped value is no finding: its exit status is that of every mistyped option.
    doctor
        .add_option(
            "--device", typed->device,
            "sim, usb or usb:SERIAL: what is to be used, by which findings are judged [sim]")
        .type_name("sim|usb[:SERIAL]")
        .check([](const std::string &text) {
            const bool is_device =
                error_text_of([&] { static_cast<void>(device_named(text)); }).empty();
            return is_device ? std::string() : text + " is not sim, usb or usb:SERIAL";
        });
    add_servo_hz_option(doctor, typed->purpose.servo_hz).check([](const std::string &text) {
        const double servo_hz = static_cast<double>(std::strtold(text.c_str(), nullptr));
        return error_text_of([&] { static_cast<void>(servo::servo_period_s(servo_hz)); });
    });
    doctor
        .add_option("--folder", typed->purpose.folder,
                    "where records are to be written: some MB are, for half a second [.]")
        .type_name("FOLDER");
    doctor.add_flag("--no-window", typed->no_window,
                    "for commands other than demo: neither display nor OpenGL is needed");
    doctor.add_flag("--json", typed->json, "JSON on standard output");
    doctor.footer("Exit status: 0, or 1 if something fails, whatever the warnings.");
    doctor.callback([typed] { run(*typed); });
}

} // namespace springdrive::app
