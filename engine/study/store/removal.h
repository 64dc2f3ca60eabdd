// Deletion of a participant, in steps that can be taken again if the program ends in between:
//
//   1. the participant is marked as being removed: nobody sees the rows any more (a transaction);
//   2. the participant's folder of servo records is removed;
//   3. all rows are deleted and their bytes overwritten, the code is replaced in what was typed of
//      others and of the study, and the file is marked as to be rebuilt (a transaction);
//   4. the file is rebuilt without unused pages, and the mark taken back.
//
// Records go before rows, because without the mark nothing would tell whose they are.
#pragma once

#include "engine/study/store/database.h"

#include <filesystem>
#include <string>

namespace springdrive::study {

/// Step 1. @throw InputError if there is no such participant
void mark_as_being_removed(const Database &database, const std::string &code);

/// Steps 2 to 4 for all who are being removed.
/// @param top  folder of the study file
/// @return in how many notes, answers and trials of others a code was replaced
/// @throw InputError if a record cannot be removed, or the file cannot be written
int complete_removals(const Database &database, const std::filesystem::path &top);

} // namespace springdrive::study
