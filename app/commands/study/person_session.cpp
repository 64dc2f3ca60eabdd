#include "app/commands/study/person_session.h"

#include "app/host/asset_folder.h"
#include "app/host/user_folder.h"
#include "app/stage/frame_loop.h"
#include "app/study/sitting/resumable.h"
#include "app/study/sitting/sitting.h"
#include "base/input_error.h"
#include "engine/session/session_report.h"
#include "engine/study/protocol/study_setting.h"

#include <algorithm>
#include <iostream>

namespace springdrive::app {

namespace {

/// The scene of the first condition that has one; else one in which nothing is touched.
std::filesystem::path first_scene(const study::Protocol &protocol,
                                  const study::ProtocolFolders &folders) {
    const auto found =
        std::ranges::find_if(protocol.conditions, [](const study::Condition &condition) {
            return condition.scene != study::kNoScene;
        });
    return found != protocol.conditions.end() ? study::scene_file_of(*found, folders)
                                              : asset_folder() / "scenes" / "plate.gltf";
}

void say_what_it_is(const session::Session &session) {
    if (session.device_choice().kind != factory::DeviceKind::usb) {
        std::cerr << "springdrive: this is a rehearsal: no person holds the "
                  << (session.device_choice().kind == factory::DeviceKind::emulated ? "emulated"
                                                                                    : "simulated")
                  << " device, its hand is led by the program; the trials are stored as such\n";
    }
}

} // namespace

void TypedSitting::add_device_to(Command &command) {
    add_device_option(command, device);
    command.add_flag("--at-zero", starts_at_zero,
                     "the device on USB is held in its zero pose at the start: upper arm level, "
                     "forearm hanging, tip at the origin");
    emulation.add_to(command, "emulated board");
    command.add_option("--cpu", cpu, "the processor to which the servo thread is bound")
        .type_name("N");
}

void TypedSitting::add_to(Command &command) {
    add_device_to(command);
    command
        .add_option("--participant-screen", window.participant.monitor,
                    "the participant's monitor, by number or a part of its name [the second; a "
                    "window if there is one only]")
        .type_name("MONITOR");
    command.add_flag("--participant-window", window.participant.is_window,
                     "the participant's screen is a window, not a whole monitor");
    command
        .add_option("--participant-width", window.participant.size.width, "of that window [1280]")
        .type_name("PIXELS");
    command
        .add_option("--participant-height", window.participant.size.height, "of that window [720]")
        .type_name("PIXELS");
    command.add_option("--width", window.size.width, "of the experimenter's window [1280]")
        .type_name("PIXELS");
    command.add_option("--height", window.size.height, "of the experimenter's window [720]")
        .type_name("PIXELS");
    command.add_option("--scale", window.scale, "of its text and panels [the display's scale]")
        .type_name("FACTOR");
    command.add_flag_callback(
        "--without-records", [this] { keeps_records = false; },
        "keep no servo record of each trial, which takes about 1 MB a second");
    command.add_flag_callback(
        "--without-noise", [this] { plays_noise = false; },
        "do not play the protocol's masking noise, as in a rehearsal");
    command.add_flag("--lockstep", is_in_lockstep,
                     "run the servo by frame time instead of the clock, which is repeatable; not "
                     "on USB");
    command.add_flag("--report", reports,
                     "for each line \"report\" on standard input, write what the experimenter's "
                     "window shows as a line of JSON");
}

session::SessionOptions session_options_of(const study::Protocol &protocol,
                                           const study::ProtocolFolders &folders,
                                           const TypedSitting &typed) {
    const study::Condition &first = protocol.conditions.front();
    const NamedDevice named = device_named(typed.device);
    if (named.kind != factory::DeviceKind::emulated && !typed.emulation.is_empty()) {
        throw InputError("--true-device-file and --fault: are for the emulated board; remove them, "
                         "or give --device emulated");
    }
    session::SessionOptions options;
    options.scene = first_scene(protocol, folders);
    options.device.file = study::device_file_of(protocol, folders);
    options.device.kind = named.kind;
    options.device.serial = named.serial;
    options.tuning = study::free_space_tuning(protocol, first).value_or(first.tuning);
    options.servo_hz = first.servo_hz;
    options.delay_periods = first.delay_periods;
    options.starts_at_zero = typed.starts_at_zero || named.kind == factory::DeviceKind::emulated;
    options.lockstep = typed.is_in_lockstep;
    options.cpu = typed.cpu;
    options.program_version = SPRINGDRIVE_VERSION;
    options.windings_folder = windings_folder();
    if (named.kind == factory::DeviceKind::emulated) {
        options.emulation.truth = typed.emulation.truth();
        options.emulation.faults = typed.emulation.parsed_faults();
    }
    return options;
}

void run_person_session(study::StudyStore &store, const study::Protocol &protocol,
                        const study::StudySetting &setting, const study::ProtocolFolders &folders,
                        const std::string &code, const TypedSitting &typed) {
    if (const std::string wrong = study_screen::validate_for_participants(protocol, setting);
        !wrong.empty()) {
        throw InputError(store.file().string() + ": " + wrong);
    }
    session::Session session = open_session(session_options_of(protocol, folders, typed));
    say_what_it_is(session);
    study_screen::StudyWindow window(typed.window, session, store, protocol);
    session.start();
    print_new_warnings(session);
    study_screen::Sitting sitting(
        store,
        {protocol, setting, folders, code, typed.keeps_records, typed.plays_noise, window.facts()},
        session, [&window](const scene::Scene &scene, const scene::TouchSpot &spot) {
            window.show_scene(scene, spot);
        });
    study_screen::SittingActivity activity(sitting, window);
    run_frames(activity, session, {.reports = typed.reports});
    session.stop();
}

} // namespace springdrive::app
