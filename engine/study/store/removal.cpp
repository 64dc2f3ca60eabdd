#include "engine/study/store/removal.h"

#include "engine/study/store/durable_files.h"
#include "engine/study/store/rows.h"

#include "base/contained_path.h"

#include <algorithm>

namespace springdrive::study {

namespace {

bool redact(Note &note, std::string_view code) { return redact_code(note.text, code); }
bool redact(QuestionnaireAnswer &answer, std::string_view code) {
    return redact_code(answer.answer, code);
}
bool redact(Trial &trial, std::string_view code) {
    return std::ranges::count_if(
               trial.marks, [&](std::string &reason) { return redact_code(reason, code); }) > 0;
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

/// @return its row
std::int64_t mark_as_being_removed(const Database &database, const std::string &code) {
    Transaction transaction(database, Transaction::Kind::write);
    for (auto &participant : rows<ParticipantRow>(database)) {
        if (participant.row.participant.code == code) {
            participant.row.is_being_removed = true;
            update(database, participant);
            transaction.commit();
            return participant.id;
        }
    }
    database.refuse(no_participant_text(code));
}

} // namespace

int remove_participant(const Database &database, const std::filesystem::path &top,
                       const std::string &code) {
    const auto folder = [&] {
        const std::filesystem::path records = study_row(database).row.facts.records_folder;
        return path_without_links(top, records / code);
    };
    if (validate_code(code).empty()) {
        static_cast<void>(folder()); // which cannot be removed: nothing is begun
    }
    const std::int64_t id = mark_as_being_removed(database, code);
    remove_folder(folder());
    int redacted = 0;
    Transaction transaction(database, Transaction::Kind::write);
    database.prepare("DELETE FROM participant WHERE id = ?").bind(id).run();
    for (const auto redact_rows :
         {redact_all<Note>, redact_all<QuestionnaireAnswer>, redact_all<Trial>}) {
        redacted += redact_rows(database, code);
    }
    auto study = study_row(database);
    ++study.row.facts.removed_participants;
    study.row.is_to_compact = true;
    update(database, study);
    transaction.commit();
    compact(database);
    return redacted;
}

void compact(const Database &database) {
    auto study = study_row(database);
    if (!study.row.is_to_compact) {
        return;
    }
    database.run("VACUUM");
    study.row.is_to_compact = false;
    Transaction transaction(database, Transaction::Kind::write);
    update(database, study);
    transaction.commit();
}

} // namespace springdrive::study
