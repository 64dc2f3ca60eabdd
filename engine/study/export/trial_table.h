// Trials and answers for other programs, as tables and as a dataset. A trial is a row; numbers have
// the fewest digits that read back as the same value.
#pragma once

#include "base/table.h"
#include "engine/study/protocol/texts.h"
#include "engine/study/store/study_contents.h"

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace springdrive::study {

/// A trial with whose and where it was.
struct TrialInStudy {
    const Trial &trial;
    const Session &session;
    const Participant &participant;
};

struct TrialColumn : Column {
    std::function<Cell(const TrialInStudy &)> cell;
};

/// The same columns for every study, in the same order; after them those of its own: of each
/// presentation the times and values ("presentation1_stiffness_N_per_m_delivered"), temperatures
/// ("winding1_degC") and tuning ("tuning_dR_Ohm"), in the order in which they appear.
[[nodiscard]] std::vector<TrialColumn> trial_columns(const StudyContents &contents);

/// Trials on devices of these kinds, in the order in which they were stored.
[[nodiscard]] std::vector<TrialInStudy> trials_in_study(const StudyContents &contents,
                                                        const std::vector<DeviceKind> &devices);

/// A row a trial.
[[nodiscard]] Table table_of(const std::vector<TrialColumn> &columns,
                             const std::vector<TrialInStudy> &trials);

// Answers to a protocol's questions as tables: a row an answer, and a row a session.

/// A row an answer, in the order in which they were stored: `participant`,
/// `participant_number`, `session`, `device_kind`, `when`, `item`, `kind`, `question`, `answer` and
/// `at_utc`. A question that was left out has no row; `when` and `kind` are empty for an item that
/// is not among `items`.
/// @param items    of the study's protocol
/// @param devices  only answers of sessions on these
[[nodiscard]] Table answer_table(const StudyContents &contents,
                                 const std::vector<QuestionnaireItem> &items,
                                 const std::vector<DeviceKind> &devices);

/// The session's answers by item, in the order of `items`; empty where there is none.
[[nodiscard]] std::vector<std::string> answers_of(const StudyContents &contents,
                                                  const std::vector<QuestionnaireItem> &items,
                                                  SessionId session);

/// Answers of sessions on that kind of device.
[[nodiscard]] std::vector<QuestionnaireAnswer> answers_on(const StudyContents &contents,
                                                          DeviceKind device);

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
// onset, duration, trial_type and response_time of BIDS, then those of `trial_columns`; "n/a" in
// cells that are empty there. There is no servo record in it: the column `record` names it.
//
// A row of questionnaire.tsv is a session with trials, a column an item of the protocol; "n/a"
// where it was not answered.

struct BidsOptions {
    std::vector<DeviceKind> devices{DeviceKind::usb};  ///< only trials on these
    std::string software = {};                         ///< version of the exporting program
    std::vector<QuestionnaireItem> questionnaire = {}; ///< of the study's protocol
    std::vector<std::string> authors = {};             ///< of the dataset
};

/// The folder appears when it is complete.
/// @throw InputError if something of that name exists, or a file cannot be written; no folder is
///        left behind
void write_bids(const StudyContents &contents, const std::filesystem::path &folder,
                const BidsOptions &options);

/// Letters and digits of a title, as BIDS names a task in files; "study" if there are none.
[[nodiscard]] std::string bids_task_label(std::string_view title);

} // namespace springdrive::study
