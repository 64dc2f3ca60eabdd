// Options that define a loop, for the commands about stability.
#pragma once

#include "app/commands/command.h"
#include "app/commands/common_options.h"
#include "engine/lab/loops/stability_parameters.h"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace springdrive::app {

struct StabilityOptions {
    std::filesystem::path device_file;
    std::filesystem::path tuning_file;         ///< empty: the default tuning
    std::vector<std::optional<double>> values; ///< of `stability_parameters()`
    std::optional<double> servo_hz;
    std::string kinematics; ///< empty: as in the tuning
    std::string drive = "spring";
    int motors = 1;
    std::vector<double> q_deg = default_joint_angles_deg();
    bool no_hand = false;

    /// The options hold references to this: it must stay where it is until the parse is over.
    void add_to(Command &command);

    /// All except those of the device, its configuration and its hands.
    [[nodiscard]] static std::vector<std::string> options_of_drive_and_servo();

    /// @throw InputError for a value out of its range, with the range.
    [[nodiscard]] loops::StabilityCase stability_case() const;
};

/// A parameter by its name. @throw InputError that lists all names.
[[nodiscard]] const loops::StabilityParameter &typed_parameter(const std::string &option,
                                                               const std::string &name);

/// @throw InputError if the parameter does not affect the case, such as gains of a current drive.
void check_that_it_counts(const std::string &option, const loops::StabilityParameter &parameter,
                          const loops::StabilityCase &which);

/// A range of it. @throw InputError if it is outside the parameter's range, or empty.
void check_parameter_range(const std::string &option, const loops::StabilityParameter &parameter,
                           double from, double to);

} // namespace springdrive::app
