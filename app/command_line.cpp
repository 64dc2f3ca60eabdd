#include "app/command_line.h"

#include "base/input_error.h"
#include "engine/control/parameters.h"
#include "engine/control/tuning_file.h"
#include "engine/servo/servo.h"

#include <CLI/CLI.hpp>

#include <array>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <string>

namespace springdrive {

namespace {

/// Options given on top of the tuning file.
struct TuningOptions {
    std::filesystem::path file;
    std::array<std::optional<double>, kParameters.size()> value;
    std::string map;
    std::string alpha_mode;

    void add_to(CLI::App &app) {
        app.add_option("--tuning-file", file, "a tuning from assets/tunings, or your own")
            ->type_name("FILE");
        for (std::size_t i = 0; i < kParameters.size(); ++i) {
            const Parameter &parameter = kParameters[i];
            app.add_option("--" + std::string(parameter.option), value[i],
                           std::string(parameter.help) + " " + std::string(parameter.equation))
                ->type_name(std::string(parameter.unit));
        }
        app.add_option("--map", map, "inverse (18) or transpose (23) kinematics")
            ->check(CLI::IsMember({"inverse", "transpose"}));
        app.add_option("--alpha-mode", alpha_mode, "where α of (23) comes from")
            ->check(CLI::IsMember({"on_the_fly", "global", "by_hand"}));
    }

    [[nodiscard]] Tuning tuning() const {
        Tuning tuning = file.empty() ? Tuning{} : read_tuning_file(file);
        for (std::size_t i = 0; i < kParameters.size(); ++i) {
            tuning.*kParameters[i].value = value[i].value_or(tuning.*kParameters[i].value);
            if (!lies_in_range(kParameters[i], tuning)) {
                throw InputError("--" + std::string(kParameters[i].option) + ": " +
                                 what_is_wrong_with(tuning));
            }
        }
        tuning.map = map.empty() ? tuning.map : *motion_map_named(map);
        tuning.alpha_mode = alpha_mode.empty() ? tuning.alpha_mode : *alpha_mode_named(alpha_mode);
        return tuning;
    }
};

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

} // namespace

std::filesystem::path asset_folder() {
    const char *chosen = std::getenv("SPRINGDRIVE_ASSETS"); // NOLINT(concurrency-mt-unsafe)
    return chosen != nullptr ? chosen : SPRINGDRIVE_ASSET_DIR;
}

std::optional<DemoOptions> parse_command_line(int argc, char **argv, int &exit_status) {
    DemoOptions options;
    options.scene = asset_folder() / "scenes" / "organic.gltf";
    options.device_file = asset_folder() / "devices" / "phantom_1_0.toml";
    TuningOptions tuning;
    std::string device = "sim";

    CLI::App app("Touch glTF meshes with a PHANTOM, simulated or real, through spring-drive "
                 "control.",
                 "springdrive");
    app.set_version_flag("--version", SPRINGDRIVE_VERSION);
    const auto add_demo_options = [&](CLI::App &to) {
        to.add_option("--scene", options.scene, "a glTF file, .gltf or .glb")->type_name("FILE");
        to.add_option("--device", device, "sim: the simulated device (usb: not in this version)")
            ->check(CLI::IsMember({"sim", "usb"}));
        to.add_option("--device-file", options.device_file, "a device from assets/devices")
            ->type_name("FILE");
        tuning.add_to(to);
        to.add_option("--servo-hz", options.servo_hz, "servo rate, 250 to 10000 [1000]")
            ->type_name("HZ");
        to.add_option("--delay", options.delay_samples,
                      "whole samples from reading θ to applying e_W, simulated [0]")
            ->type_name("D");
        to.add_option("--frames", options.frames, "end after so many frames")->type_name("N");
        to.add_option("--seconds", options.seconds, "end after so long")->type_name("S");
        to.add_option("--screenshot", options.screenshot, "write the last frame as PNG")
            ->type_name("FILE");
        to.add_option("--telemetry", options.telemetry, "write every servo tick as CSV")
            ->type_name("FILE");
        to.add_option("--path", options.path,
                      "the hand's target, a CSV file with columns t,x,y,z [s, m]")
            ->type_name("FILE");
        to.add_flag("--lockstep", options.lockstep,
                    "drive the servo by frame time instead of the clock: the same run every time");
        to.add_option("--width", options.width, "of the window, with --height [1280]")
            ->type_name("PIXELS");
        to.add_option("--height", options.height, "of the window, with --width [720]")
            ->type_name("PIXELS");
        to.add_option("--scale", options.scale, "of text and panels [the display's own]")
            ->type_name("FACTOR");
    };
    add_demo_options(app);
    CLI::App *demo = app.add_subcommand("demo", "the window (the default)");
    add_demo_options(*demo);

    try {
        app.parse(argc, argv);
    } catch (const CLI::Success &request) {
        exit_status = app.exit(request); // prints what --help or --version asked for
        return std::nullopt;
    } catch (const CLI::ParseError &error) {
        std::cerr << "springdrive: " << error.what() << "; see springdrive --help\n";
        exit_status = 2;
        return std::nullopt;
    }
    if (device == "usb") {
        throw InputError("--device usb: this version drives the simulated device only; leave the "
                         "option out");
    }
    options.tuning = tuning.tuning();
    check(options);
    return options;
}

} // namespace springdrive
