#include "base/file_names.h"

#include <array>
#include <ctime>

namespace springdrive {

std::string dated_name(std::string_view stem) {
    const std::time_t now = std::time(nullptr);
    std::tm parts{};
    localtime_r(&now, &parts);
    std::array<char, 32> text{};
    const std::size_t length = std::strftime(text.data(), text.size(), "-%Y%m%d-%H%M%S", &parts);
    return std::string(stem).append(text.data(), length);
}

} // namespace springdrive
