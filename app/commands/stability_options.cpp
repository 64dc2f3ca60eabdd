#include "app/commands/stability_options.h"

#include "app/commands/common_options.h"
#include "base/input_error.h"
#include "device/core/device_file.h"
#include "engine/lab/rig/scenario/scenarios.h"

#include <fmt/core.h>

#include <string_view>

namespace springdrive::app {

namespace {

/// The option of a parameter: `--delay` and `--servo-hz` set d and T.
std::string option_of(const loops::StabilityParameter &parameter) {
    return parameter.name == "d"   ? "--delay"
           : parameter.name == "T" ? "--servo-hz"
                                   : "--" + std::string(parameter.name);
}

bool is_of_hand(const loops::StabilityParameter &parameter) {
    return parameter.name.starts_with("hand");
}

void check(const std::string &option, const loops::StabilityParameter &parameter, double value) {
    if (const std::string wrong = validate(parameter, value); !wrong.empty()) {
        throw InputError(option + ": " + wrong);
    }
}

} // namespace

void StabilityOptions::add_to(Command &command) {
    add_device_file_option(command, device_file);
    add_tuning_file_option(command, tuning_file);
    values.resize(loops::stability_parameters().size());
    for (std::size_t i = 0; i < values.size(); ++i) {
        const loops::StabilityParameter &parameter = loops::stability_parameters()[i];
        if (parameter.name == "T") {
            command.add_option("--servo-hz", servo_hz, "servo rate, 1 to 100000 [1000]")
                .type_name("HZ");
            continue;
        }
        command.add_option(option_of(parameter), values[i], std::string(parameter.help))
            .type_name(parameter.unit == "–" ? "VALUE" : std::string(parameter.unit));
    }
    add_motion_map_option(command, "--kinematics", kinematics, " [as tuned]");
    command
        .add_option("--drive", drive,
                    "spring: the paper's; current: a conventional virtual wall [spring]")
        .one_of({"spring", "current"});
    command
        .add_option("--motors", motors,
                    "1: each motor by itself; 3: the whole linkage, its tip held at a point [1]")
        .one_of_numbers({1, 3});
    add_joint_angles_option(command, q_deg);
    command.add_flag("--no-hand", no_hand,
                     "without a hand [all must be stable: no hand, and five from light to "
                     "firm]");
}

std::vector<std::string> StabilityOptions::options_of_drive_and_servo() {
    std::vector<std::string> options{"--tuning-file", "--kinematics", "--drive", "--motors"};
    for (const loops::StabilityParameter &parameter : loops::stability_parameters()) {
        if (!is_of_hand(parameter)) {
            options.push_back(option_of(parameter));
        }
    }
    return options;
}

loops::StabilityCase StabilityOptions::stability_case() const {
    loops::StabilityCase which;
    which.device = device::read_device_file(device_file);
    which.tuning = tuning_of(tuning_file);
    which.drive = drive == "spring" ? device::AmplifierKind::spring_drive
                                    : device::AmplifierKind::current_drive;
    which.freedom = motors == 1 ? loops::Freedom::one_motor : loops::Freedom::three_motors;
    which.wall = {300.0, 2.0}; // firm enough to be felt, stable on both devices at 1 kHz
    if (!kinematics.empty()) {
        which.tuning.map = *control::motion_map_named(kinematics);
    }
    which.q_rad = joint_angles_rad(q_deg);
    rig::check_configuration(which.device, which.q_rad);
    if (servo_hz) {
        check_range("--servo-hz", *servo_hz, 1.0, 1e5);
        which.period_s = 1.0 / *servo_hz;
    }
    if (no_hand) {
        which.hands = {loops::no_hand()};
    }
    for (std::size_t i = 0; i < values.size(); ++i) {
        const loops::StabilityParameter &parameter = loops::stability_parameters()[i];
        if (!values[i]) {
            continue;
        }
        check(option_of(parameter), parameter, *values[i]);
        check_that_it_counts(option_of(parameter), parameter, which);
        parameter.set(which, *values[i]);
    }
    warn_about_margins(tuning_file, 1.0 / which.period_s, which.delay_periods);
    return which;
}

void check_that_it_counts(const std::string &option, const loops::StabilityParameter &parameter,
                          const loops::StabilityCase &which) {
    const std::string_view name = parameter.name;
    const bool current = which.drive == device::AmplifierKind::current_drive;
    const bool without_hand = which.hands.size() == 1 && which.hands.front().mass_kg == 0.0 &&
                              which.hands.front().stiffness_N_per_m == 0.0;
    const auto refuse = [&](const std::string &why) {
        const bool own = option == option_of(parameter);
        throw InputError(option + (own ? "" : " " + std::string(name)) + ": " + why);
    };
    if (current && (name == "kp" || name == "kd" || name == "dR" || name == "alpha")) {
        refuse("applies to a spring drive; omit --drive current");
    }
    if (!current && name.starts_with("wall")) {
        refuse("applies to a current drive; add --drive current");
    }
    if (name == "alpha" && which.tuning.map == control::MotionMap::inverse) {
        refuse("applies to the transpose map (23); omit --kinematics inverse");
    }
    if (which.freedom == loops::Freedom::three_motors && (name == "inertia" || name == "damping")) {
        refuse("applies to one motor by itself; omit --motors 3");
    }
    if (without_hand && is_of_hand(parameter)) {
        refuse("there is no hand; omit --no-hand");
    }
}

const loops::StabilityParameter &typed_parameter(const std::string &option,
                                                 const std::string &name) {
    const loops::StabilityParameter *parameter = loops::stability_parameter_named(name);
    if (parameter == nullptr) {
        throw InputError(option + ": there is no \"" + name + "\"; it must be one of " +
                         loops::names_of_stability_parameters());
    }
    return *parameter;
}

void check_parameter_range(const std::string &option, const loops::StabilityParameter &parameter,
                           double from, double to) {
    for (const double value : {from, to}) {
        check(option + ", from or to", parameter, value);
    }
    if (!(from < to)) {
        throw InputError(
            fmt::format("{}: {} from {:g} to {:g}: the first must be below the second, "
                        "both from {:g} to {:g}",
                        option, parameter.name, from, to, parameter.minimum, parameter.maximum));
    }
}

} // namespace springdrive::app
