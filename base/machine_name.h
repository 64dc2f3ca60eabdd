// What a time was measured on.
#pragma once

#include <istream>
#include <string>

namespace springdrive {

/// The processor's model and how many cores there are to work with, as in "AMD EPYC (2 cores)".
[[nodiscard]] std::string machine_name();

/// The model that a file like /proc/cpuinfo names first; "unknown processor" where it names none.
[[nodiscard]] std::string processor_model(std::istream &cpuinfo);

} // namespace springdrive
