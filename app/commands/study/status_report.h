// Where a study stands, for people.
#pragma once

#include "app/commands/study/opened_study.h"
#include "engine/study/conduct/conduct.h"

#include <ostream>
#include <string>
#include <vector>

namespace springdrive::app {

/// One screen: the study, a line for each participant, records and what is wrong with them.
void write_study_status(std::ostream &out, const std::filesystem::path &file,
                        const OpenedStudy &study, const std::vector<study::Progress> &participants,
                        const std::vector<std::string> &wrong_records);

} // namespace springdrive::app
