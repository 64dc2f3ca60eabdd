// Tunings in files: assets/tunings/*.toml.
#pragma once

#include "engine/control/tuning.h"

#include <filesystem>
#include <optional>
#include <ostream>
#include <string>

namespace springdrive::control {

/// The stability margins of a tuning, one quantity changed at a time, on the servo that it was
/// found for.
struct TuningMargins {
    double servo_hz = 0.0;
    double delay_periods = 0.0;   ///< d
    double gain = 1.0;            ///< the factor on K_P and K_D that is just stable
    int more_delay_periods = 0;   ///< whole periods beyond the delay that are still stable
    double min_dR_Ohm = 0.0;      ///< down to which dR may fall, as in a winding that cools
    double K_DC_Nm_per_rad = 0.0; ///< (13), for the record
    std::string worst_hand;       ///< the hand that limits the gain
    double worst_eta = 0.0;       ///< and at which η
};

struct TuningFile {
    Tuning tuning;
    std::string description;
    std::optional<TuningMargins> margins; ///< of a tuning found by `springdrive tune`
};

/// Reads a tuning file: one key for each of `kParameters` by its name, `map` = "inverse" or
/// "transpose", `alpha_mode` = "on_the_fly", "global" or "by_hand", a `description`, and where
/// there are any, `[margins]`. Files from before d was a real number have delay_samples and
/// more_delay_samples instead.
/// @throw InputError naming the file, the line, the key and the allowed values, for a file that
///        cannot be read, a missing or unknown key, or a value out of range.
[[nodiscard]] TuningFile read_whole_tuning_file(const std::filesystem::path &path);

/// The tuning of such a file.
[[nodiscard]] Tuning read_tuning_file(const std::filesystem::path &path);

/// Writes the same as text, with every digit of each number.
void write_tuning_file(std::ostream &out, const TuningFile &file);

} // namespace springdrive::control
