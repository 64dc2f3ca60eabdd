#include "engine/study/store/removal.h"

#include "engine/study/store/durable_files.h"
#include "engine/study/store/rows.h"

#include <algorithm>

namespace springdrive::study {

namespace {

bool redact(Note &note, std::string_view code) { return redact_code(note.text, code); }
bool redact(QuestionnaireAnswer &answer, std::string_view code) {
    return redact_code(answer.answer, code);
}
bool redact(TrialRow &row, std::string_view code) {
    return std::ranges::count_if(
               row.trial.marks, [&](std::string &reason) { return redact_code(reason, code); }) > 0;
}

/// In how many rows.
template <typename Row> int redact_all(const Database &database, std::string_view code) {
    int changed = 0;
    for (auto &numbered : rows<Row>(database)) {
        if (redact(numbered.row, code)) {
            update(database, numbered);
            ++changed;
        }
    }
    return changed;
}

} // namespace

void mark_as_being_removed(const Database &database, const std::string &code) {
    Transaction transaction(database, Transaction::Kind::write);
    auto participant = participant_row(database, code);
    if (!participant) {
        database.refuse(no_participant_text(code));
    }
    participant->row.is_being_removed = true;
    update(database, *participant);
    transaction.commit();
}

int complete_removals(const Database &database, const std::filesystem::path &top) {
    int redacted = 0;
    const std::string records = study_row(database).row.facts.records_folder;
    for (const auto &[id, row] : rows<ParticipantRow>(database)) {
        if (!row.is_being_removed) {
            continue;
        }
        remove_folder(top / records / row.participant.code);
        Transaction transaction(database, Transaction::Kind::write);
        database.prepare("DELETE FROM participant WHERE id = ?").bind(id).run();
        for (const auto redact_rows :
             {redact_all<Note>, redact_all<QuestionnaireAnswer>, redact_all<TrialRow>}) {
            redacted += redact_rows(database, row.participant.code);
        }
        auto study = study_row(database);
        ++study.row.facts.removed_participants;
        study.row.is_to_compact = true;
        update(database, study);
        transaction.commit();
    }
    auto study = study_row(database);
    if (study.row.is_to_compact) {
        database.run("VACUUM");
        study.row.is_to_compact = false;
        Transaction transaction(database, Transaction::Kind::write);
        update(database, study);
        transaction.commit();
    }
    return redacted;
}

} // namespace springdrive::study
