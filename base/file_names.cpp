#include "base/file_names.h"

#include <array>
#include <ctime>
#include <system_error>

namespace springdrive {

std::string local_time(const char *format, std::chrono::system_clock::time_point when) {
    const std::time_t seconds = std::chrono::system_clock::to_time_t(when);
    std::tm parts{};
    localtime_r(&seconds, &parts);
    std::array<char, 32> text{};
    return {text.data(), std::strftime(text.data(), text.size(), format, &parts)};
}

std::string dated_name(std::string_view stem) {
    return std::string(stem) + local_time("-%Y%m%d-%H%M%S");
}

std::filesystem::path numbered_name(const std::filesystem::path &first, std::size_t number) {
    std::filesystem::path name = first.stem();
    name += number == 1 ? "" : "-" + std::to_string(number);
    name += first.extension();
    return first.parent_path() / name;
}

std::filesystem::path unused_name(const std::filesystem::path &first, std::size_t number) {
    const auto exists = [](const std::filesystem::path &name) {
        std::error_code ignored;
        return std::filesystem::exists(std::filesystem::symlink_status(name, ignored));
    };
    return unused_name(first, exists, number);
}

} // namespace springdrive
