#include "engine/study/store/study_lock.h"

#include "engine/study/store/durable_files.h"
#include "engine/study/store/utc_time.h"

#include "base/input_error.h"
#include "base/new_file.h"
#include "base/one_line.h"

#include <fmt/core.h>

#include <array>
#include <cerrno>
#include <fcntl.h>
#include <string>
#include <sys/file.h>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>

namespace springdrive::study {

namespace {

std::string holder_text() {
    std::array<char, 256> host{};
    gethostname(host.data(), host.size() - 1);
    return fmt::format("process {} on {} since {}\n", getpid(), host.data(), utc_text(utc_now()));
}

std::string first_line(int descriptor) {
    std::array<char, 400> text{};
    const ssize_t count = pread(descriptor, text.data(), text.size(), 0);
    return one_line(
        std::string_view(text.data(), static_cast<std::size_t>(std::max<ssize_t>(count, 0))));
}

/// Whether the descriptor's file still has that name: its last holder removes it.
bool has_the_name(int descriptor, const std::filesystem::path &file) {
    struct stat opened {};
    struct stat named {};
    return fstat(descriptor, &opened) == 0 && lstat(file.c_str(), &named) == 0 &&
           opened.st_dev == named.st_dev && opened.st_ino == named.st_ino;
}

} // namespace

StudyLock::StudyLock(const std::filesystem::path &study, const std::filesystem::path &shown)
    : file_(study.string() + std::string(kEnding)) {
    do {
        if (descriptor_ >= 0) {
            close(descriptor_);
        }
        check_own_file(file_); // it is overwritten
        descriptor_ = open(file_.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC,
                           creation_mode(Readers::owner));
        if (descriptor_ < 0) {
            throw InputError(fmt::format("{}: cannot be locked for writing: {}; its folder must be "
                                         "writable",
                                         shown.string(), std::generic_category().message(errno)));
        }
        if (flock(descriptor_, LOCK_EX | LOCK_NB) != 0) {
            const int error = errno;
            const std::string holder = first_line(descriptor_);
            close(descriptor_);
            throw InputError(
                error == EWOULDBLOCK
                    ? fmt::format("{}: is open for writing already, by {}; end that one first",
                                  shown.string(), holder.empty() ? "another program" : holder)
                    : fmt::format("{}: cannot be locked for writing: {}; move it to a local disk",
                                  shown.string(), std::generic_category().message(error)));
        }
    } while (!has_the_name(descriptor_, file_));
    const std::string text = holder_text();
    // A help for people: the lock holds without it, on a full disk for example.
    [[maybe_unused]] const bool is_written =
        ftruncate(descriptor_, 0) == 0 && pwrite(descriptor_, text.data(), text.size(), 0) > 0;
}

StudyLock::~StudyLock() {
    unlink(file_.c_str());
    close(descriptor_);
}

} // namespace springdrive::study
