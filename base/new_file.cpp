#include "base/new_file.h"

#include "base/input_error.h"

#include <fmt/core.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <ctime>
#include <fcntl.h>
#include <fstream>
#include <sys/random.h>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>

namespace springdrive {

namespace {

constexpr int kMaxLinks = 40; ///< as Linux

std::string reason(int error) { return std::generic_category().message(error); }

/// A name that nobody can guess. Not derived from that of the file, which may have the greatest
/// length allowed.
std::string random_name() {
    std::uint64_t bits = 0;
    if (getrandom(&bits, sizeof(bits), 0) != sizeof(bits)) {
        throw InputError("no random numbers from the system: " + reason(errno));
    }
    return fmt::format(".springdrive_{:016x}", bits);
}

std::filesystem::path create_beside(const std::filesystem::path &name,
                                    const std::filesystem::path &shown, mode_t mode) {
    for (;;) {
        std::filesystem::path temporary = name.parent_path() / random_name();
        const int descriptor =
            open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, mode);
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

std::string local_time(const char *format, std::chrono::system_clock::time_point when) {
    const std::time_t seconds = std::chrono::system_clock::to_time_t(when);
    std::tm parts{};
    localtime_r(&seconds, &parts);
    std::array<char, 32> text{};
    return {text.data(), std::strftime(text.data(), text.size(), format, &parts)};
}

std::string dated_name(std::string_view stem) {
    return std::string(stem) + local_time("-%Y%m%d-%H%M%S");
}

std::filesystem::path numbered_name(const std::filesystem::path &first, std::size_t number) {
    std::filesystem::path name = first.stem();
    name += number == 1 ? "" : "-" + std::to_string(number);
    name += first.extension();
    return first.parent_path() / name;
}

std::filesystem::path unused_name(const std::filesystem::path &first, std::size_t number) {
    const auto exists = [](const std::filesystem::path &name) {
        std::error_code ignored;
        return std::filesystem::exists(std::filesystem::symlink_status(name, ignored));
    };
    return unused_name(first, exists, number);
}

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

unsigned creation_mode(Readers readers) { return readers == Readers::owner ? 0600 : 0666; }

std::error_code make_folders_for_owner(const std::filesystem::path &folder) {
    std::error_code ignored;
    if (folder.empty() || std::filesystem::is_directory(folder, ignored)) {
        return {};
    }
    if (const std::error_code error = make_folders_for_owner(folder.parent_path())) {
        return error;
    }
    return mkdir(folder.c_str(), 0700) == 0 || errno == EEXIST
               ? std::error_code()
               : std::error_code(errno, std::generic_category());
}

std::string others_access_text(const std::filesystem::path &file) {
    struct stat found {};
    if (stat(file.c_str(), &found) != 0 || (found.st_mode & 0077U) == 0) {
        return {};
    }
    return fmt::format("{}: others have rights to it (mode {:o}); unless that is meant: chmod go= "
                       "{}",
                       file.string(), found.st_mode & 0777U, file.string());
}

NewFile::NewFile(const std::filesystem::path &name, Readers readers)
    : shown_(name), name_(resolved_name(name)) {
    struct stat before {};
    const bool exists = stat(name_.c_str(), &before) == 0;
    if (exists && !S_ISREG(before.st_mode)) {
        throw InputError(name.string() + ": is not a regular file; give another name");
    }
    const mode_t mode = creation_mode(readers);
    temporary_ = create_beside(name_, name, exists ? mode & (before.st_mode | 0600U) : mode);
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
                FilePolicy policy) {
    NewFile created(file, policy.readers);
    std::ofstream stream(created.temporary(), std::ios::binary);
    write(stream);
    stream.close();
    if (!stream) {
        std::error_code ignored;
        throw InputError(file.string() + ": cannot be written completely" +
                         (std::filesystem::exists(file, ignored) ? " and is as it was" : "") +
                         "; is the disk full?");
    }
    created.publish(policy.existing);
}

} // namespace springdrive
