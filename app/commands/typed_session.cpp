#include "app/commands/typed_session.h"

#include "app/host/asset_folder.h"
#include "app/host/user_folder.h"
#include "base/input_error.h"
#include "device/core/device_file.h"
#include "engine/lab/model_selection/selection_cache.h"
#include "engine/servo/servo.h"

#include <set>
#include <utility>

namespace springdrive::app {

void ModelTyped::add_to(Command &command) {
    std::set<std::string> plants;
    for (const simulated::PlantModel &plant_model : simulated::kPlantModels) {
        plants.emplace(plant_model.name);
    }
    command
        .add_option("--model", use,
                    "full: as given by the other options; auto: the cheapest within the scene's "
                    "tolerance, measured first if necessary [full]")
        .one_of({"full", "auto"});
    command.add_option("--plant-model", plant, "which effects of the device are simulated")
        .one_of(list_of(plants));
    command
        .add_option("--step-us", step_us,
                    "the simulated device's longest sub-step, 1 to 4000 [100]")
        .type_name("US");
    command
        .add_option(
            "--contact-shape", surface,
            "haptic surface: given, flat, primitives or simplified_N, one triangle of N left; "
            "springdrive inspect lists those of a scene")
        .type_name("NAME");
}

session::ModelOptions ModelTyped::options(const TuningOptions &tuning) const {
    session::ModelOptions options;
    options.chooser = model_selection::cached_chooser();
    options.automatic = use == "auto";
    options.takes_controller =
        tuning.file.empty() && tuning.map.empty() && tuning.alpha_mode.empty();
    if (!plant.empty()) {
        options.plant = *model_selection::plant_model_named(plant);
    }
    if (step_us) {
        check_range("--step-us", *step_us, 1.0, 4000.0);
        options.longest_step_s = 1e-6 * *step_us;
    }
    if (!surface.empty()) {
        options.surface = model_selection::contact_shape_named(surface);
        if (!options.surface) {
            throw InputError("--contact-shape " + surface +
                             ": must be given, flat, primitives or simplified_N with N from 2");
        }
    }
    return options;
}

void TypedSession::add_to(Command &command) {
    options.scene = asset_folder() / "scenes" / "organic.gltf";
    command.add_option("--scene", options.scene, "a glTF file, .gltf or .glb").type_name("FILE");
    add_device_option(command, device);
    command.add_flag("--at-zero", options.starts_at_zero,
                     "the device on USB is held in its zero pose at the start, instead of zeroing "
                     "it later: upper arm level, forearm hanging, tip at the origin; an emulated "
                     "one always is");
    emulation.add_to(command, "emulated board");
    add_device_file_option(command, options.device.file);
    tuning.add_to(command);
    effects.add_to(command);
    model.add_to(command);
    add_servo_hz_option(command, options.servo_hz);
    command
        .add_option("--delay", delay_periods,
                    "periods from reading θ to applying e_W, simulated, a real number 0 to 8 [0; "
                    "of an emulated board 0.3]")
        .type_name("D");
    command
        .add_option("--path", options.path,
                    "the hand's target, a CSV file with columns t,x,y,z [s, m]")
        .type_name("FILE");
    command.add_flag_callback(
        "--without-observer", [this] { options.observes_resistance = false; },
        "set R-hat by the device file's R, not by the one observed while touching");
    command.add_option("--cpu", options.cpu, "the processor to which the servo thread is bound")
        .type_name("N");
    command
        .add_option("--late-limit-ms", late_limit_ms,
                    "stop a device with its own clock when consecutive missed deadlines add up to "
                    "more than this [the device file's]")
        .type_name("MS");
    command.add_flag("--lockstep", options.lockstep,
                     "run the servo by frame time instead of the clock, which is repeatable");
}

/// Of a device on USB nothing is simulated; behind an emulated board all is.
void TypedSession::set_device(session::SessionOptions &session) const {
    const NamedDevice named = device_named(device);
    session.device.kind = named.kind;
    session.device.serial = named.serial;
    const auto refuse = [&](bool is_given, const char *option) {
        if (is_given) {
            throw InputError(std::string(option) +
                             ": is for the simulated device; remove it, or --device " + device);
        }
    };
    const bool is_emulated = named.kind == factory::DeviceKind::emulated;
    if (!is_emulated && !emulation.is_empty()) {
        throw InputError("--true-device-file and --fault: are for the emulated board; remove them, "
                         "or give --device emulated");
    }
    session.delay_periods = delay_periods.value_or(0.0);
    if (is_emulated) {
        refuse(!(model.plant.empty() && !model.step_us), "--plant-model and --step-us");
        session.emulation.truth = emulation.truth();
        session.emulation.faults = emulation.parsed_faults();
        session.emulation.delay_periods = delay_periods.value_or(session.emulation.delay_periods);
    }
    if (named.kind == factory::DeviceKind::usb) {
        refuse(!options.path.empty(), "--path");
        refuse(delay_periods.value_or(0.0) != 0.0, "--delay");
        refuse(!(effects.without.empty() && effects.with.empty()), "--with and --without");
        refuse(effects.device_seed != 0, "--device-seed");
        refuse(!(model.plant.empty() && !model.step_us), "--plant-model and --step-us");
    }
}

session::SessionOptions TypedSession::session() const {
    static_cast<void>(servo::servo_period_s(options.servo_hz));
    session::SessionOptions session = options;
    session.program_version = SPRINGDRIVE_VERSION;
    session.windings_folder = windings_folder();
    set_device(session);
    if (late_limit_ms) {
        const double max_ms = 1e3 * device::read_device_file(session.device.file).limits.late_s;
        check_range("--late-limit-ms", *late_limit_ms, 1e-3, max_ms);
        session.late_limit_s = 1e-3 * *late_limit_ms;
    }
    session.tuning = tuning.tuning();
    warn_about_margins(tuning.file, options.servo_hz, delay_periods.value_or(0.0));
    session.effects = effects.effects();
    session.device_seed = effects.device_seed;
    session.model = model.options(tuning);
    const bool chooses_plant = session.model.automatic || session.model.plant;
    if (chooses_plant && !(effects.without.empty() && effects.with.empty())) {
        throw InputError(
            "--without and --with select what is simulated, and so do --model auto and "
            "--plant-model; give one or the other");
    }
    return session;
}

RunFiles TypedSession::files(std::vector<std::filesystem::path> written) const {
    written.push_back(options.record);
    return {{options.device.file, tuning.file, options.path, emulation.true_device_file},
            options.scene,
            std::move(written)};
}

} // namespace springdrive::app
