#include "base/input_file.h"

#include "base/input_error.h"
#include "base/text.h"

#include <fmt/core.h>

#include <algorithm>
#include <system_error>

namespace springdrive {

namespace {

bool is_control(char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; }

/// Whether `path` lies in `folder`, both with links resolved as far as they lead anywhere: where a
/// link leads to nothing, that would otherwise be told of what lies outside.
bool lies_in(const std::filesystem::path &path, const std::filesystem::path &folder) {
    auto part = path.begin();
    for (const std::filesystem::path &name : folder) {
        if (part == path.end() || *part++ != name) {
            return false;
        }
    }
    std::filesystem::path below = folder;
    for (; part != path.end(); ++part) {
        below /= *part;
        std::error_code error;
        if (std::filesystem::is_symlink(std::filesystem::symlink_status(below, error))) {
            return false;
        }
    }
    return true;
}

} // namespace

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

std::string validate_file_name(std::string_view name) {
    constexpr std::size_t kMaxBytes = 255; // of Linux
    const bool is_name = !name.empty() && name != "." && name != ".." && name.size() <= kMaxBytes &&
                         name.find('/') == std::string_view::npos &&
                         std::ranges::none_of(name, is_control);
    return is_name ? std::string() : in_quotes(name) + " is no name of a file or folder";
}

std::filesystem::path contained_file(std::string_view path, const std::filesystem::path &folder,
                                     std::string_view of) {
    const std::string its = "the " + std::string(of) + "'s ";
    if (path.starts_with('/')) {
        throw InputError("is not relative to " + its + "file and is not read; put the file into " +
                         its + "folder");
    }
    const std::filesystem::path relative = std::filesystem::path(path).lexically_normal();
    const bool is_outside = !relative.empty() && *relative.begin() == "..";
    if (is_outside || std::ranges::any_of(path, is_control)) {
        throw InputError("lies outside " + its + "folder and is not read; put the file there");
    }
    std::error_code error;
    const std::filesystem::path real_folder =
        std::filesystem::canonical(folder.empty() ? "." : folder, error);
    const std::filesystem::path real_file =
        error ? folder : std::filesystem::weakly_canonical(real_folder / relative, error);
    if (error) {
        throw InputError("cannot be read: " + error.message());
    }
    if (!lies_in(real_file, real_folder)) {
        throw InputError("lies outside " + its +
                         "folder, by way of a link, and is not read; put the file there");
    }
    return real_file;
}

std::filesystem::path path_without_links(const std::filesystem::path &folder,
                                         const std::filesystem::path &relative) {
    std::filesystem::path path = folder;
    for (const std::filesystem::path &name : relative) {
        if (const std::string problem = validate_file_name(name.native()); !problem.empty()) {
            throw InputError((folder / one_line(relative.native())).string() + ": " + problem);
        }
        path /= name;
        std::error_code ignored;
        if (std::filesystem::is_symlink(std::filesystem::symlink_status(path, ignored))) {
            throw InputError(path.string() + ": is a link, which is not followed; put there what "
                                             "it leads to");
        }
    }
    return path;
}

} // namespace springdrive
