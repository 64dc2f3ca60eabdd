#include "base/input_file.h"

#include "base/input_error.h"

#include <fmt/core.h>

#include <system_error>

namespace springdrive {

void check_input_file(const std::filesystem::path &file, std::string_view kind,
                      std::uintmax_t max_bytes) {
    std::error_code error;
    const std::filesystem::file_status status = std::filesystem::status(file, error);
    if (!std::filesystem::exists(status)) {
        return;
    }
    if (!std::filesystem::is_regular_file(status)) {
        throw InputError(fmt::format(
            "{}: is {}; name {}", file.string(),
            std::filesystem::is_directory(status) ? "a folder" : "no ordinary file", kind));
    }
    const std::uintmax_t bytes = std::filesystem::file_size(file, error);
    if (!error && bytes > max_bytes) {
        throw InputError(fmt::format("{}: has {} bytes, more than the {} of {}", file.string(),
                                     bytes, max_bytes, kind));
    }
}

} // namespace springdrive
