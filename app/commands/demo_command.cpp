#include "app/commands/demo_command.h"

#include "app/asset_folder.h"
#include "app/commands/common_options.h"
#include "app/demo.h"
#include "base/input_error.h"
#include "engine/servo/servo.h"

#include <CLI/CLI.hpp>

#include <memory>
#include <string>

namespace springdrive {

namespace {

struct Typed {
    DemoOptions options;
    TuningOptions tuning;
    EffectOptions effects;
    std::string device = "sim";
};

void add_run_options(CLI::App &demo, DemoOptions &options) {
    demo.add_option("--servo-hz", options.servo_hz, "servo rate, 250 to 10000 [1000]")
        ->type_name("HZ");
    demo.add_option("--delay", options.delay_samples,
                    "whole samples from reading θ to applying e_W, simulated [0]")
        ->type_name("D");
    demo.add_option("--frames", options.frames, "end after so many frames")->type_name("N");
    demo.add_option("--seconds", options.seconds, "end after so long")->type_name("S");
    demo.add_option("--screenshot", options.screenshot, "write the last frame as PNG")
        ->type_name("FILE");
    demo.add_option("--telemetry", options.telemetry, "write every servo tick as CSV")
        ->type_name("FILE");
    demo.add_option("--path", options.path,
                    "the hand's target, a CSV file with columns t,x,y,z [s, m]")
        ->type_name("FILE");
    demo.add_flag("--lockstep", options.lockstep,
                  "drive the servo by frame time instead of the clock: the same run every time");
}

void add_window_options(CLI::App &demo, DemoOptions &options) {
    demo.add_option("--width", options.width, "of the window, with --height [1280]")
        ->type_name("PIXELS");
    demo.add_option("--height", options.height, "of the window, with --width [720]")
        ->type_name("PIXELS");
    demo.add_option("--scale", options.scale, "of text and panels [the display's own]")
        ->type_name("FACTOR");
}

void check(const DemoOptions &options) {
    if (options.frames < 0 || !(options.seconds >= 0.0)) {
        throw InputError("--frames and --seconds must not be negative");
    }
    const bool chooses_size = options.width == 0 && options.height == 0;
    if (!chooses_size && (options.width < 320 || options.height < 240 || options.width > 16384 ||
                          options.height > 16384)) {
        throw InputError("--width and --height go together, from 320x240 to 16384x16384 pixels");
    }
    if (options.scale != 0.0 && !(options.scale >= 0.5 && options.scale <= 5.0)) {
        throw InputError("--scale must be from 0.5 to 5");
    }
    static_cast<void>(servo_period_s(options.servo_hz));
    const std::filesystem::path folder = options.screenshot.parent_path();
    if (!folder.empty() && !std::filesystem::is_directory(folder)) {
        throw InputError(options.screenshot.string() +
                         ": its folder does not exist; make it first");
    }
    if (options.lockstep && !options.unattended()) {
        throw InputError("--lockstep needs --frames or --seconds: without a clock, somebody has "
                         "to say when to end");
    }
}

void run(Typed &typed) {
    if (typed.device == "usb") {
        throw InputError("--device usb: this version drives the simulated device only; leave the "
                         "option out");
    }
    typed.options.tuning = typed.tuning.tuning();
    typed.options.effects = typed.effects.effects();
    check(typed.options);
    run_demo(typed.options);
}

} // namespace

void add_demo_command(CLI::App &app) {
    CLI::App &demo = *app.add_subcommand("demo", "the window (the default)");
    const auto typed = std::make_shared<Typed>();
    typed->options.scene = asset_folder() / "scenes" / "organic.gltf";
    demo.add_option("--scene", typed->options.scene, "a glTF file, .gltf or .glb")
        ->type_name("FILE");
    demo.add_option("--device", typed->device,
                    "sim: the simulated device (usb: not in this "
                    "version)")
        ->check(CLI::IsMember({"sim", "usb"}));
    add_device_file_option(demo, typed->options.device_file);
    typed->tuning.add_to(demo);
    typed->effects.add_to(demo);
    add_run_options(demo, typed->options);
    add_window_options(demo, typed->options);
    demo.callback([typed] { run(*typed); });
}

} // namespace springdrive
