// Deletion of a participant, in steps that can be taken again if the program ends in between:
//
//   1. the participant is marked as being removed: nobody sees the rows any more (a transaction);
//   2. the participant's folder of servo records is removed;
//   3. all rows are deleted and their bytes overwritten, the code is replaced in what was typed of
//      others and of the study, and the file is marked as to be rebuilt (a transaction);
//   4. the file is rebuilt without unused pages, and the mark taken back.
//
// Records go before rows, because without the mark nothing would tell whose they are. Files are
// removed at nobody's mark but only when somebody requests it: a study may come from anybody. The
// last step touches nothing but the study, and is also taken when it is opened.
#pragma once

#include "engine/study/store/database.h"

#include <filesystem>
#include <string>

namespace springdrive::study {

/// All steps, or those that an interrupted deletion left.
/// @param top  folder of the study file
/// @return in how many notes, answers and trials of others the code was replaced
/// @throw InputError if there is no such participant, if the folder of records is reached by a link
///        only, if a record cannot be removed, or if the file cannot be written
int remove_participant(const Database &database, const std::filesystem::path &top,
                       const std::string &code);

/// Step 4, if it is due.
void compact(const Database &database);

} // namespace springdrive::study
