#include "tests/engine/study/store/failing_disk.h"

#include "tests/engine/study/store/sample_study.h"
#include "tests/support/files.h"

#include <sqlite3.h>

#include <algorithm>
#include <csignal>
#include <cstring>
#include <fstream>
#include <map>
#include <optional>
#include <set>
#include <unistd.h>
#include <vector>

namespace springdrive::testing {

namespace {

constexpr std::size_t kSector_bytes = 512;

struct FileOnDisk {
    std::optional<std::string> durable; ///< nothing: no such name
    std::optional<std::string> present; ///< as programs see it
    std::set<std::size_t> unsynced;     ///< sectors written since
    std::optional<std::string> deleted; ///< last contents, while the deletion is not on the disk
    bool is_new = false;                ///< created, and not synced since
};

struct Disk {
    std::filesystem::path folder;
    std::map<std::string, FileOnDisk> files; ///< by name
    DiskFailure failure = DiskFailure::none;
    std::uint64_t at_call = 0;
    std::uint64_t calls = 0;
    bool has_failed = false;
};

Disk &disk() {
    static Disk only;
    return only;
}

sqlite3_vfs &real() { return *sqlite3_vfs_find(nullptr); }

std::string name_of(const char *path) { return std::filesystem::path(path).filename().string(); }

/// Counts a call that could fail. True at the moment of failure.
bool fails_now() {
    Disk &one = disk();
    const bool now =
        one.failure != DiskFailure::none && !one.has_failed && one.calls == one.at_call;
    ++one.calls;
    one.has_failed = one.has_failed || now;
    return now;
}

/// The same for a call that is not begun if the process is killed.
bool fails_as_a_whole() {
    const bool now = fails_now();
    if (now && disk().failure == DiskFailure::kill) {
        std::raise(SIGKILL);
    }
    return now;
}

bool is_without_power() { return disk().has_failed && disk().failure == DiskFailure::power_loss; }
bool is_full() { return disk().has_failed && disk().failure == DiskFailure::full; }

/// A file of SQLite's, followed in memory by the real one.
struct OpenFile {
    sqlite3_file base;
    const char *path; ///< SQLite's own text, which lives as long; null for a nameless file
    sqlite3_file real;

    static OpenFile &of(sqlite3_file *file) { return *reinterpret_cast<OpenFile *>(file); }
    [[nodiscard]] FileOnDisk *on_disk() const {
        return path == nullptr ? nullptr : &disk().files[name_of(path)];
    }
};

sqlite3_file *real_of(sqlite3_file *file) { return &OpenFile::of(file).real; }

void write_sectors(FileOnDisk &file, std::size_t at, const void *bytes, std::size_t count) {
    std::string &text = file.present.value();
    text.resize(std::max(text.size(), at + count));
    std::memcpy(text.data() + at, bytes, count);
    for (std::size_t sector = at / kSector_bytes; sector * kSector_bytes < at + count; ++sector) {
        file.unsynced.insert(sector);
    }
}

int close_file(sqlite3_file *file) { return real_of(file)->pMethods->xClose(real_of(file)); }

int read_file(sqlite3_file *file, void *to, int count, sqlite3_int64 at) {
    return is_without_power() ? SQLITE_IOERR_READ
                              : real_of(file)->pMethods->xRead(real_of(file), to, count, at);
}

int write_file(sqlite3_file *file, const void *bytes, int count, sqlite3_int64 at) {
    const bool now = fails_now();
    const int written = now ? count / 2 : count;
    if (is_without_power() && !now) {
        return SQLITE_IOERR_WRITE;
    }
    if (is_full() && !now) {
        return SQLITE_FULL;
    }
    int result = SQLITE_OK;
    if (!(now && disk().failure == DiskFailure::power_loss)) {
        result = real_of(file)->pMethods->xWrite(real_of(file), bytes, written, at);
    }
    if (now && disk().failure == DiskFailure::kill) {
        std::raise(SIGKILL);
    }
    if (FileOnDisk *const on_disk = OpenFile::of(file).on_disk()) {
        write_sectors(*on_disk, static_cast<std::size_t>(at), bytes,
                      static_cast<std::size_t>(written));
    }
    if (now) {
        return disk().failure == DiskFailure::full ? SQLITE_FULL : SQLITE_IOERR_WRITE;
    }
    return result;
}

int truncate_file(sqlite3_file *file, sqlite3_int64 size) {
    fails_as_a_whole();
    if (is_without_power()) {
        return SQLITE_IOERR_TRUNCATE;
    }
    if (FileOnDisk *const on_disk = OpenFile::of(file).on_disk()) {
        on_disk->present->resize(static_cast<std::size_t>(size));
        on_disk->unsynced.insert(static_cast<std::size_t>(size) / kSector_bytes);
    }
    return real_of(file)->pMethods->xTruncate(real_of(file), size);
}

/// Names that were created or deleted are on the disk.
void sync_names() {
    for (auto &[name, file] : disk().files) {
        file.deleted.reset();
        if (!file.present) {
            file.durable.reset();
        } else if (!file.durable) {
            file.durable.emplace(); // the name, of an empty file
        }
    }
}

int sync_file(sqlite3_file *file, int) {
    fails_as_a_whole();
    if (is_without_power()) {
        return SQLITE_IOERR_FSYNC;
    }
    if (FileOnDisk *const on_disk = OpenFile::of(file).on_disk()) {
        if (on_disk->is_new) { // SQLite syncs the folder with a new journal
            sync_names();
            on_disk->is_new = false;
        }
        on_disk->durable = on_disk->present;
        on_disk->unsynced.clear();
    }
    return SQLITE_OK; // the real disk need not wait
}

int file_size(sqlite3_file *file, sqlite3_int64 *size) {
    return real_of(file)->pMethods->xFileSize(real_of(file), size);
}
int lock_file(sqlite3_file *file, int level) {
    return real_of(file)->pMethods->xLock(real_of(file), level);
}
int unlock_file(sqlite3_file *file, int level) {
    return real_of(file)->pMethods->xUnlock(real_of(file), level);
}
int check_lock(sqlite3_file *file, int *result) {
    return real_of(file)->pMethods->xCheckReservedLock(real_of(file), result);
}
int control_file(sqlite3_file *file, int what, void *with) {
    return real_of(file)->pMethods->xFileControl(real_of(file), what, with);
}
int sector_size(sqlite3_file *) { return static_cast<int>(kSector_bytes); }
int characteristics(sqlite3_file *) { return SQLITE_IOCAP_POWERSAFE_OVERWRITE; }

constexpr sqlite3_io_methods kMethods{
    1,         close_file,  read_file,  write_file,   truncate_file, sync_file,       file_size,
    lock_file, unlock_file, check_lock, control_file, sector_size,   characteristics, nullptr,
    nullptr,   nullptr,     nullptr,    nullptr,      nullptr};

int open_file(sqlite3_vfs *, const char *path, sqlite3_file *file, int flags, int *out_flags) {
    OpenFile &opened = OpenFile::of(file);
    opened.base.pMethods = nullptr;
    opened.path = path;
    if (is_without_power()) {
        return SQLITE_CANTOPEN;
    }
    const int result = real().xOpen(&real(), path, &opened.real, flags, out_flags);
    if (opened.real.pMethods != nullptr) {
        opened.base.pMethods = &kMethods;
    }
    if (result == SQLITE_OK && path != nullptr) {
        FileOnDisk &on_disk = disk().files[name_of(path)];
        if (!on_disk.present) {
            on_disk.present.emplace();
            on_disk.unsynced.clear();
            on_disk.is_new = true;
        }
    }
    return result;
}

int delete_file(sqlite3_vfs *, const char *path, int sync_folder) {
    const bool now = fails_as_a_whole();
    // Power that is lost in the course of it: the name may be gone.
    if (is_without_power() && !now) {
        return SQLITE_IOERR_DELETE;
    }
    const int result = real().xDelete(&real(), path, 0);
    FileOnDisk &on_disk = disk().files[name_of(path)];
    if (result == SQLITE_OK && on_disk.present) {
        on_disk.deleted = on_disk.present;
        on_disk.present.reset();
    }
    if (now && disk().failure == DiskFailure::power_loss) {
        return SQLITE_IOERR_DELETE;
    }
    if (sync_folder != 0) {
        fails_as_a_whole();
        if (is_without_power()) {
            return SQLITE_IOERR_DIR_FSYNC;
        }
        sync_names();
    }
    return result;
}

int access_file(sqlite3_vfs *, const char *path, int flags, int *result) {
    return is_without_power() ? SQLITE_IOERR_ACCESS : real().xAccess(&real(), path, flags, result);
}

/// What is left of a file with unsynced sectors.
std::string remains(const FileOnDisk &file, const std::string &present, Draws &draws) {
    const std::string durable = file.durable.value_or("");
    if (file.unsynced.empty() && present.size() == durable.size()) {
        return durable;
    }
    // Of three kinds of disks: nothing is written without a sync, everything, anything.
    const int kind = draws.below(4);
    if (kind == 0) {
        return durable;
    }
    if (kind == 1) {
        return present;
    }
    std::string left = draws.coin() ? durable : present; // its length
    const std::string &old = durable;
    for (std::size_t sector = 0; sector * kSector_bytes < left.size(); ++sector) {
        const std::size_t begin = sector * kSector_bytes;
        const std::size_t end = std::min(begin + kSector_bytes, left.size());
        const int which = draws.below(3);
        const std::size_t torn = begin + draws.below(end - begin + 1);
        for (std::size_t i = begin; i < end; ++i) {
            const bool is_new =
                !file.unsynced.contains(sector) || which == 1 || (which == 2 && i < torn);
            const std::string &from = is_new ? present : old;
            left[i] = i < from.size() ? from[i] : '\0'; // a hole
        }
    }
    return left;
}

} // namespace

void install_failing_disk() {
    static sqlite3_vfs failing = [] {
        sqlite3_vfs vfs = real();
        vfs.iVersion = 1;
        vfs.szOsFile = static_cast<int>(sizeof(OpenFile)) + real().szOsFile;
        vfs.zName = kFailingDisk;
        vfs.xOpen = open_file;
        vfs.xDelete = delete_file;
        vfs.xAccess = access_file;
        return vfs;
    }();
    sqlite3_vfs_register(&failing, 0);
}

void plan_failure(const std::filesystem::path &folder, DiskFailure failure, std::uint64_t at_call) {
    disk() = {folder, {}, failure, at_call};
    for (const auto &entry : std::filesystem::directory_iterator(folder)) {
        if (entry.is_regular_file()) {
            FileOnDisk &file = disk().files[entry.path().filename().string()];
            file.durable = file.present = contents_of(entry.path());
        }
    }
}

std::uint64_t calls_of_disk() { return disk().calls; }

bool has_failed() { return disk().has_failed; }

void free_space() { disk().failure = DiskFailure::none; }

void lose_power(std::uint64_t seed) {
    Draws draws(seed);
    for (const auto &[name, file] : disk().files) {
        if (name.ends_with("-lock")) {
            continue;
        }
        const std::filesystem::path path = disk().folder / name;
        std::filesystem::remove(path);
        const bool name_changed = file.present.has_value() != file.durable.has_value();
        const bool keeps_name = name_changed ? draws.coin() : file.durable.has_value();
        if (!keeps_name) {
            continue;
        }
        const auto &newest = file.present ? file.present : file.deleted;
        std::ofstream(path, std::ios::binary)
            << remains(file, newest.value_or(file.durable.value_or("")), draws);
    }
}

} // namespace springdrive::testing

// In this program nothing waits for the disk: a loss of power is simulated (failing_disk.h), and
// what a killed process wrote survives without. On a busy disk the tests would take minutes.
//
// Defined in the program, these precede those of the C library, also for SQLite.
extern "C" {

int fsync(int /*descriptor*/) { return 0; }

int fdatasync(int /*descriptor*/) { return 0; }
}
