// The tables of a study file, and how files of earlier versions become files of this one.
//
// A new file is made as one of version 0, which is empty, and goes through all steps: so its tables
// are the same, to the letter, as those of a file that was migrated. Therefore the tables of any
// file can be compared with what they must be.
#pragma once

#include "engine/study/store/database.h"

#include <cstdint>
#include <span>

namespace springdrive::study {

/// "SDST", by which the file is known as a study of this program (`PRAGMA application_id`).
inline constexpr std::int64_t kApplicationId = 0x53445354;

/// SQL that makes a file of version n + 1 of one of version n, by its place n in the list. A value
/// that it adds to a row is not part of the row's SHA-256 where it is not set, so that rows of
/// earlier versions stay valid.
using Steps = std::span<const char *const>;

/// The version is their number.
[[nodiscard]] Steps schema_steps();

/// @throw InputError if the file is no study, or of a newer version than `steps` lead to
void check_identity(const Database &database, Steps steps);

/// @throw InputError if SQLite or a comparison with the tables of its version finds damage
/// @pre its identity was checked
void check_structure(const Database &database, Steps steps);

/// Brings it to the version to which `steps` lead, one transaction a step.
/// @pre its identity was checked, or it is empty
void migrate(const Database &database, Steps steps);

/// The version of a file (`PRAGMA user_version`).
[[nodiscard]] std::int64_t version_of(const Database &database);

} // namespace springdrive::study
