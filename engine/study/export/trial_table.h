// Trials as a table, a row a trial: its columns with what they mean. Numbers have the fewest digits
// that read back as the same value.
#pragma once

#include "base/table.h"
#include "engine/study/store/study_contents.h"

#include <functional>
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

} // namespace springdrive::study
