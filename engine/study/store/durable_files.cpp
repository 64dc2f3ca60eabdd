#include "engine/study/store/durable_files.h"

#include "base/input_error.h"

#include <cerrno>
#include <fcntl.h>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>

namespace springdrive::study {

void sync(const std::filesystem::path &file_or_folder) {
    const int descriptor = open(file_or_folder.c_str(), O_RDONLY | O_CLOEXEC);
    const bool is_synced = descriptor >= 0 && fsync(descriptor) == 0;
    const int error = errno;
    if (descriptor >= 0) {
        close(descriptor);
    }
    // Some file systems cannot sync a folder, and do not need it.
    if (!is_synced && error != EINVAL) {
        throw InputError(file_or_folder.string() + ": cannot be written to the disk: " +
                         std::generic_category().message(error) + "; check the disk");
    }
}

void sync_folders(const std::filesystem::path &file, const std::filesystem::path &top) {
    std::filesystem::path folder = file;
    do {
        folder = folder.parent_path();
        sync(folder);
    } while (folder != top && folder.has_relative_path());
}

void check_own_file(const std::filesystem::path &file) {
    struct stat found {};
    if (lstat(file.c_str(), &found) == 0 && (!S_ISREG(found.st_mode) || found.st_nlink > 1)) {
        throw InputError(file.string() + ": is a link or no ordinary file, which springdrive never "
                                         "makes of that name; move it away");
    }
}

void remove_folder(const std::filesystem::path &folder) {
    std::error_code error;
    if (!std::filesystem::exists(std::filesystem::symlink_status(folder, error))) {
        return;
    }
    std::filesystem::remove_all(folder, error);
    if (error) {
        throw InputError(folder.string() + ": cannot be removed: " + error.message() +
                         "; make it writable and repeat");
    }
    sync(folder.parent_path());
}

} // namespace springdrive::study
