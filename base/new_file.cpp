#include "base/new_file.h"

#include "base/input_error.h"

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <fcntl.h>
#include <fstream>
#include <string_view>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>

namespace springdrive {

namespace {

constexpr int kMaxLinks = 40; ///< as Linux

std::string reason(int error) { return std::generic_category().message(error); }

/// Beside `name`, and of no other process or thread. Not derived from `name`, which may have the
/// greatest length allowed.
std::filesystem::path create_beside(const std::filesystem::path &name,
                                    const std::filesystem::path &shown) {
    static std::atomic<unsigned> count{0};
    for (;;) {
        std::filesystem::path temporary =
            name.parent_path() /
            (".springdrive_" + std::to_string(getpid()) + "_" + std::to_string(count++));
        const int descriptor =
            open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (descriptor >= 0) {
            close(descriptor);
            return temporary;
        }
        if (errno != EEXIST) {
            throw InputError(shown.string() + ": cannot be written: " + reason(errno) +
                             "; check its folder and permissions");
        }
    }
}

/// 0, or the error: EEXIST if there is a file of the name.
int rename_without_replacing(const std::filesystem::path &from, const std::filesystem::path &to) {
    if (renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) {
        return 0;
    }
    if (errno != EINVAL && errno != ENOSYS) {
        return errno;
    }
    // A file system that does not know it.
    if (link(from.c_str(), to.c_str()) == 0) {
        unlink(from.c_str());
        return 0;
    }
    return errno;
}

} // namespace

std::filesystem::path resolved_name(const std::filesystem::path &name) {
    std::error_code ignored;
    std::filesystem::path resolved = std::filesystem::absolute(name, ignored);
    for (int i = 0; i < kMaxLinks; ++i) {
        const std::filesystem::path folder =
            std::filesystem::weakly_canonical(resolved.parent_path(), ignored);
        resolved = folder / resolved.filename();
        if (folder.string().starts_with("/proc/") ||
            !std::filesystem::is_symlink(resolved, ignored)) {
            break;
        }
        resolved = folder / std::filesystem::read_symlink(resolved, ignored);
    }
    return resolved;
}

NewFile::NewFile(const std::filesystem::path &name) : shown_(name), name_(resolved_name(name)) {
    std::error_code ignored;
    if (std::filesystem::exists(name_, ignored) &&
        !std::filesystem::is_regular_file(name_, ignored)) {
        throw InputError(name.string() + ": is not a regular file; give another name");
    }
    temporary_ = create_beside(name_, name);
}

NewFile::~NewFile() {
    if (!temporary_.empty()) {
        unlink(temporary_.c_str());
    }
}

void NewFile::publish(Existing existing) {
    int error = 0;
    if (existing == Existing::keep) {
        error = rename_without_replacing(temporary_, name_);
    } else {
        struct stat before {};
        if (stat(name_.c_str(), &before) == 0) {
            // Best effort: a file system may have no permissions.
            [[maybe_unused]] const int result = chmod(temporary_.c_str(), before.st_mode & 07777U);
        }
        error = rename(temporary_.c_str(), name_.c_str()) == 0 ? 0 : errno;
    }
    if (error == EEXIST) {
        throw InputError(exists_text(shown_));
    }
    if (error != 0) {
        throw InputError(shown_.string() + ": cannot be written: " + reason(error) +
                         "; name another file");
    }
    temporary_.clear();
}

std::string exists_text(const std::filesystem::path &file) {
    return file.string() + ": exists; use --force to replace it";
}

void write_file(const std::filesystem::path &file, const std::function<void(std::ostream &)> &write,
                Existing existing) {
    NewFile created(file);
    std::ofstream stream(created.temporary(), std::ios::binary);
    write(stream);
    stream.close();
    if (!stream) {
        std::error_code ignored;
        throw InputError(file.string() + ": cannot be written completely" +
                         (std::filesystem::exists(file, ignored) ? " and is as it was" : "") +
                         "; is the disk full?");
    }
    created.publish(existing);
}

} // namespace springdrive
