#include "tests/support/files.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <unistd.h>

namespace springdrive::testing {

std::filesystem::path fresh_folder(const std::string &name) {
    const std::filesystem::path folder = std::filesystem::path(::testing::TempDir()) /
                                         ("springdrive_" + std::to_string(getpid()) + "_" + name);
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
    return folder;
}

std::string contents_of(const std::filesystem::path &file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

} // namespace springdrive::testing
