// Trials as a table, a row a trial: its columns with what they mean, and CSV.
//
// Numbers have the fewest digits that read back as the same value; true is 1, false is 0. What is
// not known or does not apply is an empty cell.
#pragma once

#include "engine/study/store/study_contents.h"

#include <functional>
#include <iosfwd>
#include <string>
#include <utility>
#include <vector>

namespace springdrive::study {

/// A trial with whose and where it was.
struct TrialInStudy {
    const Trial &trial;
    const Session &session;
    const Participant &participant;
};

struct TrialColumn {
    std::string name;
    std::string description;
    std::string unit;                                        ///< as in BIDS; empty: none
    std::vector<std::pair<std::string, std::string>> levels; ///< values with their meaning
    std::function<std::string(const TrialInStudy &)> cell;   ///< text, not quoted
};

/// The same columns for every study, in the same order; after them those of its own: of each
/// presentation the times and values ("presentation1_stiffness_N_per_m_delivered"), temperatures
/// ("winding1_degC") and tuning ("tuning_dR_Ohm"), in the order in which they appear.
[[nodiscard]] std::vector<TrialColumn> trial_columns(const StudyContents &contents);

/// Trials on devices of these kinds, in the order in which they were stored.
[[nodiscard]] std::vector<TrialInStudy> trials_in_study(const StudyContents &contents,
                                                        const std::vector<DeviceKind> &devices);

/// A line of names, then a line a trial.
void write_trials_csv(const StudyContents &contents, const std::vector<DeviceKind> &devices,
                      std::ostream &out);

} // namespace springdrive::study
