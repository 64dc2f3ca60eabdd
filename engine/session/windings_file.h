// What is known of a device's windings from one run of the program to the next: upper bounds of
// their temperatures, in a small file for each serial number.
//
//   start ──take──► the file is gone ── run ── orderly end ──store──► file
//
// So after a crash there is none, and windings may be as hot as a monitor permits. The bounds cool
// by the time that this computer's clock since its start says has passed, suspended or not; after
// another start of the computer they stay, because its date may be wrong, and are not used if the
// date is before theirs. Another computer may have used the device meanwhile: only its board, as
// long as it has power, knows of that.
#pragma once

#include "device/core/motor/winding_heat.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>

namespace springdrive::session {

struct StoringTime {
    std::int64_t utc_s = 0;    ///< since 1970
    std::string boot;          ///< names this start of the computer; empty where it has no name
    double since_boot_s = 0.0; ///< also while it was suspended
};
[[nodiscard]] StoringTime storing_time();

/// @param folder  empty: there is no file
[[nodiscard]] std::filesystem::path windings_file(const std::filesystem::path &folder,
                                                  const std::string &serial);

/// Upper bounds now, of motors that nobody drives since; removes the file. The hottest that motors
/// can be if it is missing or damaged, another device's or of a later time, or cannot be removed.
[[nodiscard]] std::array<device::MotorTemperature, 3>
take_windings(const std::filesystem::path &folder, const std::string &serial,
              const std::array<device::MotorParameters, 3> &motors, const StoringTime &now);

/// Makes the folder, too. @return false if it cannot be written: there is then no file
bool store_windings(const std::filesystem::path &folder, const std::string &serial,
                    const std::array<device::MotorTemperature, 3> &hottest, const StoringTime &now);

} // namespace springdrive::session
