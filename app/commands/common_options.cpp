#include "app/commands/common_options.h"

#include "app/asset_folder.h"
#include "base/input_error.h"
#include "base/print.h"
#include "device/core/motor/winding_guard.h"
#include "engine/control/tuning_file.h"
#include "engine/servo/servo.h"

#include <CLI/CLI.hpp>

#include <fmt/core.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <fcntl.h>
#include <fstream>
#include <iostream>
#include <set>
#include <system_error>
#include <unistd.h>

namespace springdrive::app {

namespace {

bool shapes_the_coupling(const control::Parameter &parameter) {
    return parameter.value != &control::Tuning::alpha_rad2_per_m2 &&
           parameter.value != &control::Tuning::eta;
}

/// 0 where it worked.
int error_of_closing(int descriptor) {
    const int error = descriptor < 0 ? errno : 0;
    if (descriptor >= 0) {
        close(descriptor);
    }
    return error;
}

/// What would be in the way of writing `output`; 0 for nothing. Tried where that leaves no trace:
/// permissions alone do not tell it all.
int error_of_writing(const std::filesystem::path &output, const std::filesystem::path &folder) {
    std::error_code problem;
    const std::filesystem::file_type type = std::filesystem::status(output, problem).type();
    if (type == std::filesystem::file_type::none) { // its name is too long, say
        return problem.value();
    }
    if (type == std::filesystem::file_type::regular) {
        return error_of_closing(open(output.c_str(), O_WRONLY | O_CLOEXEC));
    }
    if (type != std::filesystem::file_type::not_found) { // whoever reads a pipe would see it end
        return access(output.c_str(), W_OK) == 0 ? 0 : errno;
    }
    std::string beside = folder / ".springdrive_XXXXXX";
    const int error = error_of_closing(mkstemp(beside.data()));
    if (error == 0) {
        unlink(beside.c_str());
    }
    return error;
}

} // namespace

void add_device_file_option(CLI::App &command, std::filesystem::path &file) {
    file = asset_folder() / "devices" / "phantom_1_0.toml";
    command.add_option("--device-file", file, "a device from assets/devices")->type_name("FILE");
}

CLI::Option *add_servo_hz_option(CLI::App &command, double &servo_hz) {
    return command
        .add_option("--servo-hz", servo_hz,
                    fmt::format("servo rate, {:g} to {:g} [{:g}]", servo::kSlowest_hz,
                                servo::kFastest_hz, servo_hz))
        ->type_name("HZ");
}

void TuningOptions::add_to(CLI::App &command, TuningScope scope) {
    command.add_option("--tuning-file", file, "a tuning from assets/tunings, or your own")
        ->type_name("FILE");
    for (std::size_t i = 0; i < control::kParameters.size(); ++i) {
        const control::Parameter &parameter = control::kParameters[i];
        if (scope == TuningScope::coupling && !shapes_the_coupling(parameter)) {
            continue;
        }
        command
            .add_option("--" + std::string(parameter.option), value[i],
                        std::string(parameter.help) + " " + std::string(parameter.equation))
            ->type_name(std::string(parameter.unit));
    }
    if (scope == TuningScope::coupling) {
        return;
    }
    command.add_option("--map", map, "inverse (18) or transpose (23) kinematics")
        ->check(CLI::IsMember(list_of(control::kMotionMapNames)));
    command.add_option("--alpha-mode", alpha_mode, "where α of (23) comes from")
        ->check(CLI::IsMember(list_of(control::kAlphaModeNames)));
}

void EffectOptions::add_to(CLI::App &command) {
    std::set<std::string> names{"all"};
    std::string list;
    for (const simulated::PlantEffect &effect : simulated::kPlantEffects) {
        names.emplace(effect.name);
        list += (list.empty() ? "" : ", ") + std::string(effect.name);
    }
    command
        .add_option("--without", without,
                    "switch effects of the simulated device off: all, or any of " + list)
        ->type_name("EFFECT,...")
        ->delimiter(',')
        ->check(CLI::IsMember(names));
    command
        .add_option("--with", with, "switch them on again; only structural_compliance starts off")
        ->type_name("EFFECT,...")
        ->delimiter(',')
        ->check(CLI::IsMember(names));
}

simulated::PlantEffects EffectOptions::effects() const {
    simulated::PlantEffects effects;
    const auto set = [&effects](const std::vector<std::string> &names, bool on) {
        for (const simulated::PlantEffect &effect : simulated::kPlantEffects) {
            const bool named = std::any_of(names.begin(), names.end(), [&](const auto &name) {
                return name == effect.name || name == "all";
            });
            effects.*effect.on = named ? on : effects.*effect.on;
        }
    };
    set(without, false);
    set(with, true);
    return effects;
}

control::Tuning TuningOptions::tuning() const {
    control::Tuning tuning = file.empty() ? control::Tuning{} : control::read_tuning_file(file);
    for (std::size_t i = 0; i < control::kParameters.size(); ++i) {
        tuning.*control::kParameters[i].value =
            value[i].value_or(tuning.*control::kParameters[i].value);
        if (!control::lies_in_range(control::kParameters[i], tuning)) {
            throw InputError("--" + std::string(control::kParameters[i].option) + ": " +
                             control::what_is_wrong_with(tuning));
        }
    }
    tuning.map = map.empty() ? tuning.map : *control::motion_map_named(map);
    tuning.alpha_mode =
        alpha_mode.empty() ? tuning.alpha_mode : *control::alpha_mode_named(alpha_mode);
    return tuning;
}

void remark_on_margins(const std::filesystem::path &tuning_file, double servo_hz,
                       double delay_periods) {
    if (tuning_file.empty()) {
        return;
    }
    const std::optional<control::TuningMargins> margins =
        control::read_whole_tuning_file(tuning_file).margins;
    if (margins && (servo_hz < margins->servo_hz || delay_periods > margins->delay_periods)) {
        print(std::cerr,
              "springdrive: remark: {} was found for {:g} Hz and a delay of {:g}; on a slower or "
              "later servo its margins do not hold\n",
              tuning_file.string(), margins->servo_hz, margins->delay_periods);
    }
}

void check_dR(const device::DeviceDescription &device, const control::Tuning &tuning) {
    for (std::size_t j = 0; j < device.motor.size(); ++j) {
        const device::MotorParameters &motor = device.motor[j];
        if (device::residual_resistance_Ohm(motor, tuning.dR_Ohm) != tuning.dR_Ohm) {
            throw InputError(fmt::format(
                "dR is {:g} Ω; on motor {} of {} it must be from {:g} to its R, {:g} Ω",
                tuning.dR_Ohm, j + 1, device.name,
                device::kLeastResidualShare * motor.resistance_Ohm, motor.resistance_Ohm));
        }
    }
}

double cold_dR_Ohm(const device::DeviceDescription &device, const control::Tuning &tuning) {
    double least_Ohm = tuning.dR_Ohm;
    for (const device::MotorParameters &motor : device.motor) {
        least_Ohm = std::max(least_Ohm, device::least_cold_residual_Ohm(motor, device.amplifier));
    }
    if (least_Ohm > tuning.dR_Ohm) {
        print(std::cerr,
              "springdrive: remark: the servo holds dR at {:g} Ω, not at {:g} Ω, until it knows "
              "the windings to be warm\n",
              least_Ohm, tuning.dR_Ohm);
    }
    return least_Ohm;
}

void check_range(const std::string &what, double value, double lowest, double highest) {
    if (!(value >= lowest && value <= highest)) { // a NaN too
        throw InputError(
            fmt::format("{} is {:g}; it must be from {:g} to {:g}", what, value, lowest, highest));
    }
}

void check_other_file(const std::filesystem::path &output, const std::filesystem::path &input) {
    if (output.empty() || input.empty()) {
        return;
    }
    std::error_code ignored;
    if (std::filesystem::equivalent(output, input, ignored) ||
        std::filesystem::weakly_canonical(output, ignored) ==
            std::filesystem::weakly_canonical(input, ignored)) {
        throw InputError(output.string() + ": is the record itself; give another name");
    }
}

void check_writable(const std::filesystem::path &output) {
    if (output.empty() || output == "-") {
        return;
    }
    const std::filesystem::path folder = output.has_parent_path() ? output.parent_path() : ".";
    std::error_code problem;
    if (!std::filesystem::is_directory(folder, problem)) {
        throw InputError(output.string() + ": its folder does not exist; make it first");
    }
    if (std::filesystem::is_directory(output, problem)) {
        throw InputError(output.string() + ": is a folder; name a file");
    }
    if (const int error = error_of_writing(output, folder); error != 0) {
        throw InputError(output.string() + ": cannot be written: " +
                         std::generic_category().message(error) + "; name another file");
    }
}

void make_output_folder(const std::filesystem::path &folder) {
    std::error_code problem;
    std::filesystem::create_directories(folder, problem);
    if (problem) {
        throw InputError("--out " + folder.string() + ": cannot be made: " + problem.message());
    }
    if (access(folder.c_str(), W_OK | X_OK) != 0) {
        throw InputError("--out " + folder.string() +
                         ": you may not write there; name another folder");
    }
}

void write_output(const std::string &where, const std::function<void(std::ostream &)> &write) {
    if (where == "-") {
        write(std::cout);
        if (!std::cout.flush()) {
            throw InputError("standard output: cannot be written; is its disk full or its reader "
                             "gone?");
        }
        return;
    }
    std::ofstream file(where, std::ios::binary);
    if (!file) {
        throw InputError(where + ": cannot be created; does its folder exist, and may you write "
                                 "there?");
    }
    write(file);
    if (!file.flush()) {
        throw InputError(where + ": cannot be written to the end; is the disk full?");
    }
}

} // namespace springdrive::app
