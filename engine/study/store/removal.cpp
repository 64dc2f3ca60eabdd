#include "engine/study/store/removal.h"

#include "engine/study/store/durable_files.h"
#include "engine/study/store/rows.h"

#include "base/one_line.h"

namespace springdrive::study {

void mark_as_being_removed(const Database &database, const std::string &code) {
    Transaction transaction(database, Transaction::Kind::write);
    auto participant = participant_row(database, code);
    if (!participant) {
        database.refuse("has no participant " + in_quotes(code));
    }
    participant->row.is_being_removed = true;
    update(database, *participant);
    transaction.commit();
}

void complete_removals(const Database &database, const std::filesystem::path &top) {
    const std::string records = study_row(database).row.facts.records_folder;
    for (const auto &[id, row] : rows<ParticipantRow>(database)) {
        if (!row.is_being_removed) {
            continue;
        }
        remove_folder(top / records / row.participant.code);
        Transaction transaction(database, Transaction::Kind::write);
        database.prepare("DELETE FROM participant WHERE id = ?").bind(id).run();
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
}

} // namespace springdrive::study
