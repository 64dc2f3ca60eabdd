#include "app/commands/common_options.h"

#include "app/host/folders.h"
#include "app/stage/frame_loop.h"
#include "base/degrees.h"
#include "base/input_error.h"
#include "base/print.h"
#include "device/core/device_file.h"
#include "device/core/motor/winding_heat.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/tuning_file.h"
#include "engine/lab/model_selection/selection_cache.h"
#include "engine/lab/rig/scenario/test_surfaces.h"
#include "engine/servo/servo.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <set>
#include <unistd.h>
#include <utility>

namespace springdrive::app {

namespace {

/// Whether K_θ (12) depends on the parameter.
bool shapes_the_coupling(const control::Parameter &parameter) {
    return parameter.value != &control::Tuning::alpha_rad2_per_m2 &&
           parameter.value != &control::Tuning::eta;
}

} // namespace

void add_device_file_option(Command &command, std::filesystem::path &file) {
    file = asset_folder() / "devices" / "phantom_1_0.toml";
    command
        .add_option("--device-file", file,
                    "a device, as those in " + (asset_folder() / "devices").string())
        .type_name("FILE");
}

void add_device_option(Command &command, std::string &device) {
    command
        .add_option("--device", device,
                    "sim: the simulated device; usb: the board on USB; usb:SERIAL: one of several; "
                    "emulated: a board in this process, to rehearse with [sim]")
        .type_name("sim|usb[:SERIAL]|emulated");
}

NamedDevice device_named(const std::string &device) {
    const std::size_t colon = device.find(':');
    const auto kind = factory::device_kind_named(device.substr(0, colon));
    if (!kind || (*kind != factory::DeviceKind::usb && colon != std::string::npos)) {
        throw InputError("--device " + device + ": must be sim, usb, usb:SERIAL or emulated");
    }
    return {*kind, colon == std::string::npos ? "" : device.substr(colon + 1)};
}

void TypedEmulation::add_to(Command &command, const std::string &device) {
    command
        .add_option("--true-device-file", true_device_file,
                    "what the " + device + " is, if it is another one [the device file]")
        .type_name("FILE");
    command
        .add_option("--fault", faults,
                    "what fails of the " + device +
                        ", as in springdrive device emulate; may be repeated")
        .type_name("FAULT");
}

std::optional<device::DeviceDescription> TypedEmulation::truth() const {
    if (true_device_file.empty()) {
        return std::nullopt;
    }
    return device::read_device_file(true_device_file);
}

std::vector<device::Fault> TypedEmulation::parsed_faults() const {
    std::vector<device::Fault> parsed;
    for (const std::string &fault : faults) {
        parsed.push_back(device::parse_fault(fault));
    }
    return parsed;
}

void add_tuning_file_option(Command &command, std::filesystem::path &file) {
    command
        .add_option("--tuning-file", file,
                    "a tuning, your own or one of those in " +
                        (asset_folder() / "tunings").string())
        .type_name("FILE");
}

control::Tuning tuning_of(const std::filesystem::path &file) {
    return file.empty() ? control::Tuning{} : control::read_tuning_file(file);
}

std::vector<double> default_joint_angles_deg() {
    return {device::kDefaultPose_deg.begin(), device::kDefaultPose_deg.end()};
}

void add_joint_angles_option(Command &command, std::vector<double> &q_deg) {
    command
        .add_option("--q", q_deg,
                    fmt::format("the three joint angles in degrees [{:g}]",
                                fmt::join(device::kDefaultPose_deg, ",")))
        .type_name("A,B,C")
        .delimiter(',')
        .expected(3);
}

Vector3 joint_angles_rad(const std::vector<double> &q_deg) {
    if (!std::ranges::all_of(q_deg, [](double angle) { return std::isfinite(angle); })) {
        throw InputError("--q: every angle must be a finite number of degrees");
    }
    return kRadiansPerDegree * Vector3(q_deg[0], q_deg[1], q_deg[2]);
}

void add_motion_map_option(Command &command, const std::string &option, std::string &map,
                           std::string_view warning) {
    command
        .add_option(option, map,
                    fmt::format("{} or {}{}", control::label_of(control::MotionMap::inverse),
                                control::label_of(control::MotionMap::transpose), warning))
        .one_of(list_of(control::kMotionMapNames));
}

Option add_servo_hz_option(Command &command, double &servo_hz) {
    return command
        .add_option("--servo-hz", servo_hz,
                    fmt::format("servo rate, {:g} to {:g} [{:g}]", servo::kMinRate_hz,
                                servo::kMaxRate_hz, servo_hz))
        .type_name("HZ");
}

Option add_delay_option(Command &command, double &delay_periods) {
    return command
        .add_option("--delay", delay_periods,
                    fmt::format("periods from reading θ to applying e_W, a real number 0 to {} [0]",
                                simulated::SimulationOptions::kMaxDelay))
        .type_name("D");
}

void check_delay(double delay_periods) {
    check_range("--delay", delay_periods, 0, simulated::SimulationOptions::kMaxDelay);
}

void TuningOptions::add_to(Command &command, TuningScope scope) {
    add_tuning_file_option(command, file);
    for (std::size_t i = 0; i < control::kParameters.size(); ++i) {
        const control::Parameter &parameter = control::kParameters[i];
        if (scope == TuningScope::coupling && !shapes_the_coupling(parameter)) {
            continue;
        }
        command
            .add_option("--" + std::string(parameter.option), value[i],
                        std::string(parameter.help) + " " + std::string(parameter.equation))
            .type_name(std::string(parameter.unit));
    }
    if (scope == TuningScope::coupling) {
        return;
    }
    add_motion_map_option(command, "--map", map, " kinematics");
    command.add_option("--alpha-mode", alpha_mode, "the source of α of (23)")
        .one_of(list_of(control::kAlphaModeNames));
}

control::Tuning TuningOptions::tuning() const {
    control::Tuning tuning = tuning_of(file);
    for (std::size_t i = 0; i < control::kParameters.size(); ++i) {
        const control::Parameter &parameter = control::kParameters[i];
        tuning.*parameter.value = value[i].value_or(tuning.*parameter.value);
        if (!control::lies_in_range(parameter, tuning)) {
            throw InputError("--" + std::string(parameter.option) + ": " +
                             control::validate(tuning));
        }
    }
    tuning.map = map.empty() ? tuning.map : *control::motion_map_named(map);
    tuning.alpha_mode =
        alpha_mode.empty() ? tuning.alpha_mode : *control::alpha_mode_named(alpha_mode);
    return tuning;
}

void EffectOptions::add_to(Command &command) {
    std::set<std::string> names{"all"};
    std::string list;
    for (const simulated::PlantEffect &effect : simulated::kPlantEffects) {
        names.emplace(effect.name);
        list += (list.empty() ? "" : ", ") + std::string(effect.name);
    }
    command
        .add_option("--without", without,
                    "switch effects of the simulated device off: all, or any of " + list)
        .type_name("EFFECT,...")
        .delimiter(',')
        .one_of(list_of(names));
    command
        .add_option(
            "--with", with,
            "switch them on again; only structural_compliance and cable_compliance start off")
        .type_name("EFFECT,...")
        .delimiter(',')
        .one_of(list_of(names));
    command
        .add_option(
            "--device-seed", device_seed,
            "which device of its kind is simulated: motors and current sensors drawn within "
            "the device file's tolerances; 0 is the file's own, with ideal sensors")
        .type_name("N")
        .in_range(0, 1'000'000'000)
        .capture_default_str();
}

simulated::PlantEffects EffectOptions::effects() const {
    simulated::PlantEffects effects;
    const auto set = [&effects](const std::vector<std::string> &names, bool on) {
        for (const simulated::PlantEffect &effect : simulated::kPlantEffects) {
            const bool is_named = std::ranges::any_of(names, [&](const std::string &name) {
                return name == effect.name || name == "all";
            });
            if (is_named) {
                effects.*effect.on = on;
            }
        }
    };
    set(without, false);
    set(with, true);
    return effects;
}

void warn_about_margins(const std::filesystem::path &tuning_file, double servo_hz,
                        double delay_periods) {
    if (tuning_file.empty()) {
        return;
    }
    const std::optional<control::TuningMargins> margins =
        control::read_whole_tuning_file(tuning_file).margins;
    if (margins && (servo_hz < margins->servo_hz || delay_periods > margins->delay_periods)) {
        print(std::cerr,
              "springdrive: remark: {} was found for {:g} Hz and a delay of {:g}; on a slower or "
              "later servo its margins do not apply\n",
              tuning_file.string(), margins->servo_hz, margins->delay_periods);
    }
}

void check_dR(const device::DeviceDescription &device, const control::Tuning &tuning) {
    for (std::size_t j = 0; j < device.motor.size(); ++j) {
        const device::MotorParameters &motor = device.motor[j];
        if (device::residual_resistance_Ohm(motor, tuning.dR_Ohm) != tuning.dR_Ohm) {
            throw InputError(fmt::format(
                "dR is {:g} Ω; on motor {} of {} it must be from {:g} to its R, {:g} Ω",
                tuning.dR_Ohm, j + 1, device.name, device::kMinResidualShare * motor.resistance_Ohm,
                motor.resistance_Ohm));
        }
    }
}

double cold_dR_Ohm(const device::DeviceDescription &device, const control::Tuning &tuning) {
    double dR_Ohm = tuning.dR_Ohm;
    for (const device::MotorParameters &motor : device.motor) {
        dR_Ohm = std::max(dR_Ohm, device::min_cold_residual_Ohm(motor, device.amplifier));
    }
    if (dR_Ohm > tuning.dR_Ohm) {
        print(std::cerr,
              "springdrive: remark: the servo limits dR to {:g} Ω or more, by each motor's R, not "
              "{:g} Ω, until the windings are certain to be warm\n",
              dR_Ohm, tuning.dR_Ohm);
    }
    return dR_Ohm;
}

void check_range(const std::string &what, double value, double minimum, double maximum) {
    if (!(value >= minimum && value <= maximum)) { // a NaN too
        throw InputError(
            fmt::format("{} is {:g}; it must be from {:g} to {:g}", what, value, minimum, maximum));
    }
}

void add_gltf_scene_option(Command &command, std::string &gltf_scene) {
    command
        .add_option("--gltf-scene", gltf_scene,
                    "which of a glTF file's scenes, by its name or number [its default, else the "
                    "first that has triangles]")
        .type_name("NAME");
}

scene::Scene load_scene_with_progress(const std::string &name, const std::string &gltf_scene,
                                      const device::Workspace &workspace) {
    scene::LoadProgress progress;
    std::optional<LoadProgressPrinter> printer;
    if (isatty(STDERR_FILENO) != 0) {
        printer.emplace(std::filesystem::path(name).filename().string(), progress, std::cerr);
    }
    return rig::touch_scene(name, workspace, &progress, gltf_scene);
}

void TypedModel::add_to(Command &command) {
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

session::ModelOptions TypedModel::options(const TuningOptions &tuning) const {
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
    add_gltf_scene_option(command, options.gltf_scene);
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

session::SessionOptions TypedSession::session() const {
    static_cast<void>(servo::servo_period_s(options.servo_hz)); // throws if out of range
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
    if (chooses_plant && effects.switches_effects()) {
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

/// Options of the simulation are refused where nothing is simulated, on USB, and those of the plant
/// also for an emulated board, which simulates all of it.
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
        refuse(model.overrides_plant(), "--plant-model and --step-us");
        session.emulation.truth = emulation.truth();
        session.emulation.faults = emulation.parsed_faults();
        session.emulation.delay_periods = delay_periods.value_or(session.emulation.delay_periods);
    }
    if (named.kind == factory::DeviceKind::usb) {
        refuse(!options.path.empty(), "--path");
        refuse(delay_periods.value_or(0.0) != 0.0, "--delay");
        refuse(effects.switches_effects(), "--with and --without");
        refuse(effects.device_seed != 0, "--device-seed");
        refuse(model.overrides_plant(), "--plant-model and --step-us");
    }
}

} // namespace springdrive::app
