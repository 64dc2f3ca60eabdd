#include "tests/support/files.h"

#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <fstream>
#include <iterator>
#include <sys/wait.h>
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

std::string said_in_child(const std::function<void()> &prepare,
                          const std::function<std::string()> &step) {
    std::array<int, 2> ends{};
    EXPECT_EQ(pipe(ends.data()), 0);
    const pid_t child = fork();
    if (child == 0) {
        prepare();
        const std::string said = step();
        const bool sent = write(ends[1], said.data(), said.size()) == std::ssize(said);
        _exit(sent ? 0 : 1);
    }
    close(ends[1]);
    std::string said;
    std::array<char, 4096> part{};
    for (ssize_t got = 0; (got = read(ends[0], part.data(), part.size())) > 0;) {
        said.append(part.data(), static_cast<std::size_t>(got));
    }
    close(ends[0]);
    int status = 0;
    waitpid(child, &status, 0);
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
    return said;
}

void drop_rights() {
    constexpr uid_t kNobody = 65534;
    [[maybe_unused]] const int result = geteuid() == 0 ? setuid(kNobody) : 0;
}

} // namespace springdrive::testing
