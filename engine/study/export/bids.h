// A study as a dataset of the Brain Imaging Data Structure (BIDS), version 1.9.0, behaviour only:
// https://bids-specification.readthedocs.io, "Events", "Behavioral experiments" and "Phenotypic and
// assessment data".
//
//   FOLDER/
//     dataset_description.json, README, participants.tsv, participants.json
//     task-LABEL_events.json                   what the columns mean, for all events files
//     phenotype/questionnaire.tsv, phenotype/questionnaire.json      if the protocol asks questions
//     sub-P01/ses-01/beh/sub-P01_ses-01_task-LABEL_events.tsv, ...
//
// A row of an events file is a trial, in the order in which they were stored: with the columns
// onset, duration, trial_type and response_time of BIDS, then those of trial_table.h; "n/a" in
// cells that are empty there. There is no servo record in it: the column `record` names it.
//
// A row of questionnaire.tsv is a session with trials, a column an item of the protocol; "n/a"
// where it was not answered.
#pragma once

#include "engine/study/protocol/questionnaire.h"
#include "engine/study/store/study_contents.h"

#include <filesystem>
#include <string>
#include <vector>

namespace springdrive::study {

struct BidsOptions {
    std::vector<DeviceKind> devices{DeviceKind::usb};  ///< only trials on these
    std::string software = {};                         ///< version of the exporting program
    std::vector<QuestionnaireItem> questionnaire = {}; ///< of the study's protocol
};

/// The folder appears when it is complete.
/// @throw InputError if something of that name exists, or a file cannot be written; no folder is
///        left behind
void write_bids(const StudyContents &contents, const std::filesystem::path &folder,
                const BidsOptions &options);

/// Letters and digits of a title, as BIDS names a task in files; "study" if there are none.
[[nodiscard]] std::string bids_task_label(std::string_view title);

} // namespace springdrive::study
