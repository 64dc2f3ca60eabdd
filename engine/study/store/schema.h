// The tables of a study file. A file of another version is refused, not changed: who made it has
// the program for it.
#pragma once

#include "engine/study/store/database.h"

#include <cstdint>

namespace springdrive::study {

/// "SDST", by which the file is known as a study of this program (`PRAGMA application_id`).
inline constexpr std::int64_t kApplicationId = 0x53445354;

/// Of the tables and of the rows' SHA-256 (`PRAGMA user_version`).
inline constexpr std::int64_t kVersion = 2;

/// @throw InputError if the file is no study, or of another version
void check_identity(const Database &database);

/// @throw InputError if SQLite or a comparison with the tables of a new study finds damage
/// @pre its identity was checked
void check_structure(const Database &database);

/// Makes an empty database a study without rows, in one transaction.
void create_tables(const Database &database);

} // namespace springdrive::study
