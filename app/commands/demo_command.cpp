#include "app/commands/command.h"

#include "app/commands/common_options.h"
#include "app/commands/output_files.h"
#include "app/demo/demo.h"
#include "app/exhibit/day_log.h"
#include "app/exhibit/tour.h"
#include "app/panels/window_habits.h"
#include "base/input_error.h"

#include <cstddef>
#include <fstream>
#include <memory>
#include <string>
#include <system_error>

namespace springdrive::app {

namespace {

struct TypedDemo {
    TypedSession session;
    DemoOptions options;
    std::filesystem::path shown; ///< by a file manager, which names no option
    bool resets_settings = false;
};

void add_run_options(Command &demo, TypedDemo &typed) {
    DemoOptions &options = typed.options;
    demo.add_option("--frames", options.frames, "end after this many frames").type_name("N");
    demo.add_option("--seconds", options.seconds, "end after this time").type_name("S");
    demo.add_option("--open", options.opened, "show a record, or the folder of a kept session")
        .type_name("PATH");
    demo.add_option("file", typed.shown,
                    "a scene, as with --scene; or a record or kept session, as with --open")
        .type_name("FILE")
        .excludes(demo.get_option("--scene"))
        .excludes(demo.get_option("--open"));
    demo.add_option("--screenshot", options.screenshot, "write the last frame as PNG")
        .type_name("FILE");
    demo.add_option("--record", typed.session.options.record,
                    "record every servo tick; see springdrive export")
        .type_name("FILE");
    add_force_option(demo, options.existing);
    demo.add_option("--width", options.width, "of the window, with --height [1280]")
        .type_name("PIXELS");
    demo.add_option("--height", options.height, "of the window, with --width [720]")
        .type_name("PIXELS");
    demo.add_option("--scale", options.scale, "of text and panels [the display's scale]")
        .type_name("FACTOR");
    demo.add_option(
            "--settings", options.settings,
            "where the window remembers size, text and recent files "
            "[~/.config/springdrive/settings.toml; with --frames, --seconds or --report none]")
        .type_name("FILE");
    demo.add_flag("--reset-settings", typed.resets_settings,
                  "forget them first: the window is as in a first run");
    demo.add_flag("--assistant", options.assistant,
                  "open the assistant: step by step from the connection to the first touch");
    demo.add_flag(
        "--kiosk", options.kiosk,
        "an exhibit: a tour of the scenes for visitors, in full screen and without panels; "
        "ended by Ctrl+Alt+Q or SIGTERM");
    demo.add_option("--log", options.day_log,
                    "of a kiosk's day [~/.local/state/springdrive/kiosk/DATE.log]")
        .type_name("FILE");
    demo.add_flag(
        "--report", options.reports,
        "for each line \"report\" on standard input, write what the window shows as a line "
        "of JSON; with --lockstep, frames are drawn only for these");
    demo.add_flag("--unseen", options.unseen,
                  "compute every frame, but draw only those that are written to a file");
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
    if (options.session.lockstep && !options.unattended() && !options.reports) {
        throw InputError("--lockstep needs --frames or --seconds to end, or --report to ask for "
                         "frames, as it does not use the clock");
    }
}

/// A script finds the same window every time, unless it names a file.
void choose_settings(DemoOptions &options, bool resets) {
    const bool is_script = options.unattended() || options.reports;
    const std::filesystem::path usual = settings_file();
    if (resets) {
        SettingsKeeper keeper(options.settings.empty() ? usual : options.settings);
        (void)keeper.take_error(); // of a file that is damaged, which is removed
        keeper.reset();
        if (const std::string error = keeper.take_error(); !error.empty()) {
            throw InputError(error);
        }
    }
    if (options.settings.empty() && !is_script && !options.kiosk) {
        options.settings = usual;
    }
}

/// Nothing of what the options make remains to a kiosk's visitors.
void check_kiosk(const TypedDemo &typed, const Command &demo) {
    const auto refuse = [&](const char *option, const char *why) {
        if (demo.has_been_given(option)) {
            throw InputError(std::string(option) + ": not with --kiosk, " + why);
        }
    };
    if (!typed.options.kiosk) {
        if (demo.has_been_given("--log")) {
            throw InputError("--log: is for a kiosk; add --kiosk");
        }
        return;
    }
    for (const char *option : {"--scene", "--gltf-scene", "file", "--open"}) {
        refuse(option, "which shows its own tour");
    }
    refuse("--at-zero", "which may start while nobody holds the device: zero it by Ctrl+Alt+Z");
    refuse("--assistant", "whose visitors commission no device");
    refuse("--path", "whose hand is scripted by its tour");
    refuse("--settings", "whose window is as it is");
    refuse("--reset-settings", "whose window is as it is");
    if (typed.session.options.model.automatic || typed.session.model.use == "auto") {
        throw InputError("--model auto: not with --kiosk, whose gains stay as they are at the "
                         "start; give them with --tuning-file");
    }
}

/// A log that is named must be possible; the usual one may fail, which is said.
void choose_day_log(DemoOptions &options) {
    if (options.day_log.empty()) {
        options.day_log = exhibit::usual_day_log();
        return;
    }
    const bool is_device = !std::filesystem::is_regular_file(options.day_log) &&
                           std::filesystem::exists(options.day_log);
    if (is_device || !std::ofstream(options.day_log, std::ios::app)) {
        throw InputError("--log " + options.day_log.string() +
                         ": cannot be written; is its folder there, and yours?");
    }
}

void make_kiosk(DemoOptions &options) {
    options.session.scene = exhibit::file_of(exhibit::kTour.front());
    options.session.plays_script = false;
    // Nobody is there to say so: an emulated board is always opened in its zero pose.
    const bool is_emulated = options.session.device.kind == factory::DeviceKind::emulated;
    options.session.starts_at_zero = options.session.starts_at_zero || is_emulated;
    options.session.history_bytes = std::size_t{32} << 20; // no plot shows more than the moment
    choose_day_log(options);
}

/// By its kind, as a file that is dropped on the window.
void place_shown(TypedDemo &typed) {
    std::error_code ignored;
    if (typed.shown.extension() == ".rec" || std::filesystem::is_directory(typed.shown, ignored)) {
        typed.options.opened = typed.shown;
    } else if (!typed.shown.empty()) {
        typed.session.options.scene = typed.shown;
    }
}

void run(TypedDemo typed, const Command &demo) {
    check_kiosk(typed, demo);
    place_shown(typed);
    DemoOptions options = typed.options;
    options.session = typed.session.session();
    options.session.plays_script = options.unattended();
    options.session.existing_record = options.existing;
    if (options.kiosk) {
        make_kiosk(options);
    }
    check(options);
    std::error_code ignored;
    if (!options.opened.empty() && !std::filesystem::exists(options.opened, ignored)) {
        throw InputError(options.opened.string() + ": not found; --open takes a record or the "
                                                   "folder of a kept session");
    }
    check_outputs(typed.session.files({options.screenshot}), options.existing);
    choose_settings(options, typed.resets_settings);
    if (const int status = run_demo(options); status != 0) {
        end_with_status(status);
    }
}

} // namespace

void add_demo_command(Command &app) {
    Command demo = app.add_subcommand("demo", "the window (the default)");
    const auto typed = std::make_shared<TypedDemo>();
    typed->session.add_to(demo);
    add_run_options(demo, *typed);
    demo.callback([typed, demo] { run(*typed, demo); });
}

} // namespace springdrive::app
