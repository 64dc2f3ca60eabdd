#include "base/timing.h"

#include "base/parallel.h"

#include <fstream>

namespace springdrive {

std::string processor_model(std::istream &cpuinfo) {
    std::string line;
    while (std::getline(cpuinfo, line)) {
        const std::size_t colon = line.find(':');
        if (colon == std::string::npos || !line.starts_with("model name")) {
            continue;
        }
        const std::size_t first = line.find_first_not_of(" \t", colon + 1);
        if (first != std::string::npos) {
            return line.substr(first);
        }
    }
    return "unknown processor";
}

std::string machine_name() {
    std::ifstream cpuinfo("/proc/cpuinfo");
    const unsigned cores = all_processors();
    return processor_model(cpuinfo) + " (" + std::to_string(cores) +
           (cores == 1 ? " core)" : " cores)");
}

} // namespace springdrive
