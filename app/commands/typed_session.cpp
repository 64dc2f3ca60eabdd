#include "app/commands/typed_session.h"

#include "app/asset_folder.h"
#include "base/input_error.h"
#include "engine/servo/servo.h"

#include <CLI/CLI.hpp>

namespace springdrive {

void TypedSession::add_to(CLI::App &command) {
    options.scene = asset_folder() / "scenes" / "organic.gltf";
    command.add_option("--scene", options.scene, "a glTF file, .gltf or .glb")->type_name("FILE");
    command
        .add_option("--device", device,
                    "sim: the simulated device (usb: not in this "
                    "version)")
        ->check(CLI::IsMember({"sim", "usb"}));
    add_device_file_option(command, options.device_file);
    tuning.add_to(command);
    effects.add_to(command);
    command.add_option("--servo-hz", options.servo_hz, "servo rate, 250 to 10000 [1000]")
        ->type_name("HZ");
    command
        .add_option("--delay", options.delay_samples,
                    "whole samples from reading θ to applying e_W, simulated [0]")
        ->type_name("D");
    command
        .add_option("--path", options.path,
                    "the hand's target, a CSV file with columns t,x,y,z [s, m]")
        ->type_name("FILE");
    command.add_option("--cpu", options.cpu, "the processor that the servo's thread is to stay on")
        ->type_name("N");
    command
        .add_option("--missed-limit", options.missed_limit,
                    "stop the device after more deadlines missed in a row than this [the device "
                    "file's]")
        ->type_name("N");
    command.add_flag("--lockstep", options.lockstep,
                     "drive the servo by frame time instead of the clock: the same run every time");
}

SessionOptions TypedSession::session() const {
    if (device == "usb") {
        throw InputError("--device usb: this version drives the simulated device only; leave the "
                         "option out");
    }
    static_cast<void>(servo_period_s(options.servo_hz));
    SessionOptions session = options;
    session.tuning = tuning.tuning();
    session.effects = effects.effects();
    return session;
}

} // namespace springdrive
