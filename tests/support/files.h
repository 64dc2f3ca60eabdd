// Files of a test's own.
#pragma once

#include <filesystem>
#include <string>

namespace springdrive::testing {

/// A folder of its own for one test, empty. It goes when the process ends, unless a test failed.
[[nodiscard]] std::filesystem::path fresh_folder(const std::string &name);

[[nodiscard]] std::string contents_of(const std::filesystem::path &file);

} // namespace springdrive::testing
