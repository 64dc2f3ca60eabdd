// Names of files and folders that the program chooses itself.
#pragma once

#include <chrono>
#include <concepts>
#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

namespace springdrive {

/// A time in a format of strftime, by the local clock; at most 31 letters.
[[nodiscard]] std::string
local_time(const char *format,
           std::chrono::system_clock::time_point when = std::chrono::system_clock::now());

/// "plots-20240531-123456" of "plots", by the local time.
[[nodiscard]] std::string dated_name(std::string_view stem);

/// "touch.rec" of number 1, "touch-2.rec" of number 2.
[[nodiscard]] std::filesystem::path numbered_name(const std::filesystem::path &first,
                                                  std::size_t number);

/// The first of "touch.rec", "touch-2.rec", "touch-3.rec", ... that is not taken.
/// @param is_taken  tells it of a name
template <std::predicate<const std::filesystem::path &> IsTaken>
[[nodiscard]] std::filesystem::path unused_name(const std::filesystem::path &first,
                                                IsTaken &&is_taken, std::size_t number = 1) {
    std::filesystem::path name = numbered_name(first, number);
    while (is_taken(name)) {
        name = numbered_name(first, ++number);
    }
    return name;
}

/// The first from `number` on of which there is no file, folder or link.
[[nodiscard]] std::filesystem::path unused_name(const std::filesystem::path &first,
                                                std::size_t number = 1);

} // namespace springdrive
