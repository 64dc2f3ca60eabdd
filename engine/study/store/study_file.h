// Study files: what is on the disk when a call returns, who may write, and how files are made and
// opened with all checks.
#pragma once

#include "engine/study/store/database.h"
#include "engine/study/store/study_store.h"

#include <filesystem>
#include <string>
#include <string_view>

namespace springdrive::study {

/// Waits until a file, or the names in a folder, are on the disk.
/// @throw InputError if that fails
void sync(const std::filesystem::path &file_or_folder);

/// The same for the entries of all folders from a file's up to `top`.
void sync_folders(const std::filesystem::path &file, const std::filesystem::path &top);

/// Of a file that only this program makes, beside a study.
/// @throw InputError if something has its name that is no file of its own: a link of either kind, a
///        folder, a device
void check_own_file(const std::filesystem::path &file);

/// Removes a folder with all that is in it, and waits until it is gone from the disk. Links are
/// removed, not followed. Nothing is done if there is none.
/// @throw InputError if something cannot be removed
void remove_folder(const std::filesystem::path &folder);

// One writer at a time: an advisory lock on "STUDY-lock" beside the study, held while it is open
// for writing. The system drops it with the process, however that ends. The file names who holds
// it.

class StudyLock {
public:
    static constexpr std::string_view kEnding = "-lock";

    /// @param study  resolved name; @param shown  as in messages
    /// @throw InputError, at once, if another program (or this one) holds it, naming that; or if
    ///        the folder is write-protected.
    StudyLock(const std::filesystem::path &study, const std::filesystem::path &shown);
    ~StudyLock();
    StudyLock(const StudyLock &) = delete;
    StudyLock &operator=(const StudyLock &) = delete;

private:
    std::filesystem::path file_;
    int descriptor_ = -1;
};

/// The file's name with all links followed, so that it has one lock and one journal.
/// @throw InputError if there is no ordinary file of that name
[[nodiscard]] std::filesystem::path name_of_existing(const std::filesystem::path &file);

/// Makes an empty database a study without participants.
void fill_new(const Database &database, const NewStudy &study, UtcTime now,
              const std::string &records_folder);

/// Opens a file for writing, and checks all that is in it.
/// @throw InputError, see StudyStore
[[nodiscard]] Database open_to_write(const std::filesystem::path &file,
                                     const std::filesystem::path &shown,
                                     const DatabaseSettings &settings);

} // namespace springdrive::study
