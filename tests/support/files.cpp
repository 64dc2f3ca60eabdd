#include "tests/support/files.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <system_error>
#include <unistd.h>

namespace springdrive::testing {

namespace {

/// This process's folder. It is kept for inspection if a test failed.
class OutputDir {
public:
    OutputDir()
        : path(std::filesystem::path(::testing::TempDir()) /
               ("springdrive_" + std::to_string(process_))) {
        std::filesystem::remove_all(path);
        std::filesystem::create_directories(path);
    }
    ~OutputDir() {
        const bool is_forked = getpid() != process_;
        if (!is_forked && !::testing::UnitTest::GetInstance()->Failed()) {
            std::error_code ignored;
            std::filesystem::remove_all(path, ignored);
        }
    }
    OutputDir(const OutputDir &) = delete;
    OutputDir &operator=(const OutputDir &) = delete;

private:
    pid_t process_ = getpid();

public:
    const std::filesystem::path path;
};

} // namespace

std::filesystem::path fresh_folder(const std::string &name) {
    static const OutputDir own;
    const std::filesystem::path folder = own.path / name;
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
    return folder;
}

std::string contents_of(const std::filesystem::path &file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

} // namespace springdrive::testing
