// Names of files and folders that the program chooses itself.
#pragma once

#include <string>
#include <string_view>

namespace springdrive {

/// "plots-20240531-123456" of "plots", by the local time.
[[nodiscard]] std::string dated_name(std::string_view stem);

/// The first of "touch.rec", "touch-2.rec", "touch-3.rec", ... that is not taken.
/// @param is_taken  tells it of a name
template <typename IsTaken>
[[nodiscard]] std::string unused_name(const std::string &stem, const std::string &ending,
                                      IsTaken &&is_taken) {
    std::string name = stem + ending;
    for (int number = 2; is_taken(name); ++number) {
        name = stem + '-' + std::to_string(number) + ending;
    }
    return name;
}

} // namespace springdrive
