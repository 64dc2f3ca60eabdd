// Files of a test's own.
#pragma once

#include <filesystem>
#include <string>

namespace springdrive::testing {

/// A folder of its own for one test, empty.
[[nodiscard]] std::filesystem::path fresh_folder(const std::string &name);

[[nodiscard]] std::string contents_of(const std::filesystem::path &file);

} // namespace springdrive::testing
