// Temporary files of tests.
#pragma once

#include <filesystem>
#include <string>

namespace springdrive::testing {

/// An empty folder for one test. It is removed when the process ends, unless a test failed.
[[nodiscard]] std::filesystem::path fresh_folder(const std::string &name);

[[nodiscard]] std::string contents_of(const std::filesystem::path &file);

} // namespace springdrive::testing
