// Making study files, and opening them with all checks.
#pragma once

#include "engine/study/store/database.h"
#include "engine/study/store/study_store.h"

#include <filesystem>
#include <string>

namespace springdrive::study {

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
