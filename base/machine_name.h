// Identifies the machine on which a time was measured.
#pragma once

#include <istream>
#include <string>

namespace springdrive {

/// The processor's model and the number of available cores, as in "AMD EPYC (2 cores)".
[[nodiscard]] std::string machine_name();

/// The first model name in a file like /proc/cpuinfo; "unknown processor" if there is none.
[[nodiscard]] std::string processor_model(std::istream &cpuinfo);

} // namespace springdrive
