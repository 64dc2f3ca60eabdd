#include "engine/study/store/study_store.h"

#include "base/input_error.h"
#include "base/input_file.h"
#include "base/new_file.h"
#include "base/sha256.h"
#include "base/text.h"
#include "engine/study/store/database.h"
#include "engine/study/store/rows.h"
#include "engine/study/store/study_file.h"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

namespace springdrive::study {

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

/// Step 4, if it is due.
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

/// All steps, or those that an interrupted deletion left; `top` is the folder of the study file.
/// @return in how many notes, answers and trials of others the code was replaced
/// @throw InputError if there is no such participant, if the folder of records is reached by a link
///        only, if a record cannot be removed, or if the file cannot be written
int remove_rows_and_records(const Database &database, const std::filesystem::path &top,
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

/// Sessions of a program that ended without a word.
void end_interrupted(const Database &database) {
    Transaction transaction(database, Transaction::Kind::write);
    for (auto &session : rows<Session>(database)) {
        if (!session.row.ending) {
            session.row.ending = SessionEnding::interrupted;
            update(database, session);
        }
    }
    transaction.commit();
}

} // namespace

struct StudyStore::Parts {
    Parts(const std::filesystem::path &file, const DatabaseSettings &settings)
        : shown(file), resolved(name_of_existing(file)), lock(std::in_place, resolved, shown),
          database(open_to_write(resolved, shown, settings)) {}

    /// In memory.
    Parts(const NewStudy &study, UtcTime now)
        : shown("a study in memory"), database(Database::in_memory(shown)) {
        fill_new(database, study, now, "none.records");
    }

    [[nodiscard]] std::filesystem::path top() const { return resolved.parent_path(); }

    /// @throw InputError "FILE: problem", unless that is empty
    void check(const std::string &problem) const {
        if (!problem.empty()) {
            database.refuse(problem);
        }
    }
    void check_participant(const std::string &code) const {
        if (!participant_row(database, code)) {
            database.refuse(no_participant_text(code));
        }
    }
    void check_session(SessionId id, const std::string &participant) const {
        const auto found = rows<Session>(database, id);
        if (found.empty() || found.front().row.participant != participant) {
            database.refuse(
                fmt::format("has no session {} of participant {}", id, in_quotes(participant)));
        }
    }

    std::filesystem::path shown;
    std::filesystem::path resolved; ///< empty: in memory
    std::optional<StudyLock> lock;  ///< of a file
    Database database;              ///< closed before the lock is given back
};

StudyStore::StudyStore(const std::filesystem::path &file) : StudyStore(file, DatabaseSettings{}) {}

StudyStore::StudyStore(const std::filesystem::path &file, const DatabaseSettings &settings)
    : parts_(std::make_unique<Parts>(file, settings)) {
    end_interrupted(parts_->database);
    compact(parts_->database);
}

StudyStore::StudyStore(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}

StudyStore StudyStore::in_memory(const NewStudy &study, UtcTime now) {
    return StudyStore(std::make_unique<Parts>(study, now));
}

StudyStore::~StudyStore() = default;
StudyStore::StudyStore(StudyStore &&) noexcept = default;
StudyStore &StudyStore::operator=(StudyStore &&) noexcept = default;

const std::filesystem::path &StudyStore::file() const {
    return parts_->resolved.empty() ? parts_->resolved : parts_->shown;
}

StudyContents StudyStore::contents() const {
    const Transaction transaction(parts_->database, Transaction::Kind::read);
    return read_contents(parts_->database);
}

void StudyStore::add(const Participant &participant) {
    const Database &database = parts_->database;
    parts_->check(validate(participant));
    Transaction transaction(database, Transaction::Kind::write);
    for (const auto &[id, row] : rows<ParticipantRow>(database)) {
        if (row.participant.code == participant.code) {
            database.refuse("has a participant " + participant.code + " already");
        }
        if (is_mistaken_for(participant.code, row.participant.code)) {
            database.refuse(fmt::format("has a participant {1}, for whom {0} would be taken; name "
                                        "{1}, or give a new one another number",
                                        participant.code, row.participant.code));
        }
        if (row.participant.number == participant.number) {
            database.refuse(fmt::format("has a participant of number {} already: {}",
                                        participant.number, row.participant.code));
        }
    }
    insert(database, ParticipantRow{participant, false});
    transaction.commit();
}

SessionId StudyStore::begin(const Session &session) {
    const Database &database = parts_->database;
    parts_->check(validate(session));
    Transaction transaction(database, Transaction::Kind::write);
    parts_->check_participant(session.participant);
    Session begun = session;
    begun.ended.reset();
    begun.ending.reset();
    const SessionId id = insert(database, begun);
    transaction.commit();
    return id;
}

void StudyStore::end(SessionId session, SessionEnding ending, UtcTime at) {
    const Database &database = parts_->database;
    Transaction transaction(database, Transaction::Kind::write);
    auto found = rows<Session>(database, session);
    if (found.empty() || found.front().row.ending) {
        database.refuse(fmt::format("has no session {} that runs", session));
    }
    found.front().row.ending = ending;
    found.front().row.ended = at;
    update(database, found.front());
    transaction.commit();
}

Appended StudyStore::append(const Trial &trial) {
    const Database &database = parts_->database;
    Transaction transaction(database, Transaction::Kind::write);
    parts_->check(validate(trial, study_row(database).row.facts.records_folder));
    if (const auto stored = trial_row(database, trial.participant, trial.place)) {
        if (digest_of(0, stored->row) != digest_of(0, trial)) {
            database.refuse(fmt::format("has another trial of {} already: {}", trial.participant,
                                        text_of(trial.place)));
        }
        return Appended::before;
    }
    parts_->check_participant(trial.participant);
    parts_->check_session(trial.session, trial.participant);
    if (trial.repetition_of && !trial_row(database, trial.participant, *trial.repetition_of)) {
        database.refuse(fmt::format("has no trial of {} to be repeated: {}", trial.participant,
                                    text_of(*trial.repetition_of)));
    }
    if (trial.repetition_of && has_repetition(database, trial.participant, *trial.repetition_of)) {
        database.refuse("has a repetition already of " + text_of(*trial.repetition_of));
    }
    insert(database, trial);
    transaction.commit();
    return Appended::now;
}

Appended StudyStore::add(const QuestionnaireAnswer &answer) {
    const Database &database = parts_->database;
    parts_->check(validate(answer));
    Transaction transaction(database, Transaction::Kind::write);
    parts_->check_participant(answer.participant);
    parts_->check_session(answer.session, answer.participant);
    if (const auto stored = answer_row(database, answer.session, answer.item)) {
        if (stored->question != answer.question || stored->answer != answer.answer) {
            database.refuse(fmt::format("has another answer of {} to {} already, in session {}",
                                        answer.participant, in_quotes(answer.item),
                                        answer.session));
        }
        return Appended::before;
    }
    insert(database, answer);
    transaction.commit();
    return Appended::now;
}

void StudyStore::append(const Note &note) {
    const Database &database = parts_->database;
    parts_->check(validate(note));
    Transaction transaction(database, Transaction::Kind::write);
    if (note.participant) {
        parts_->check_participant(*note.participant);
    }
    if (note.session) {
        parts_->check_session(*note.session, *note.participant);
    }
    insert(database, note);
    transaction.commit();
}

Removed StudyStore::remove_participant(std::string_view code) {
    parts_->check(parts_->resolved.empty() ? "is gone with the program by itself" : "");
    const Database &database = parts_->database;
    Removed removed;
    removed.redacted = remove_rows_and_records(database, parts_->top(), std::string(code));
    const StudyFacts facts = study_row(database).row.facts;
    for (const std::string &text : {facts.title, facts.protocol, facts.records_folder}) {
        removed.is_in_study = removed.is_in_study || has_code(text, code);
    }
    return removed;
}

std::filesystem::path StudyStore::new_record_file(std::string_view participant,
                                                  const TrialPlace &place) const {
    parts_->check_participant(std::string(participant));
    parts_->check(parts_->resolved.empty() ? "keeps no servo records" : "");
    const std::string records = study_row(parts_->database).row.facts.records_folder;
    const std::filesystem::path folder =
        path_without_links(parts_->top(), std::filesystem::path(records) / participant);
    if (const std::error_code error = make_folders_for_owner(folder)) {
        throw InputError(folder.string() + ": cannot be made: " + error.message() +
                         "; check the study's folder and permissions");
    }
    return folder / fmt::format("block{}-position{:03}-attempt{}.rec", place.block, place.position,
                                place.attempt);
}

RecordLink StudyStore::link_to(const std::filesystem::path &record) const {
    const std::filesystem::path resolved = resolved_name(record);
    const std::filesystem::path path = resolved.lexically_relative(parts_->top());
    const std::string records = study_row(parts_->database).row.facts.records_folder;
    if (path.empty() || *path.begin() != records) {
        throw InputError(record.string() + ": is not in the study's folder of records, " + records);
    }
    RecordLink link{path, sha256_of_file(resolved)};
    sync(resolved);
    sync_folders(resolved, parts_->top());
    return link;
}

std::vector<std::string> validate_records(const std::filesystem::path &file,
                                          const StudyContents &contents) {
    std::vector<std::string> problems;
    const std::filesystem::path top = resolved_name(file).parent_path();
    for (const Trial &trial : contents.trials) {
        if (!trial.record) {
            continue;
        }
        const std::string where = fmt::format("{}: record of {}, {}", trial.record->path.string(),
                                              trial.participant, text_of(trial.place));
        std::error_code ignored;
        try {
            const std::filesystem::path record = path_without_links(top, trial.record->path);
            if (!std::filesystem::is_regular_file(record, ignored)) {
                problems.push_back(where + ": is missing");
            } else if (sha256_of_file(record) != trial.record->sha256) {
                problems.push_back(where + ": is another file than the one that was linked");
            }
        } catch (const InputError &error) {
            problems.push_back(where + ": " + error.what());
        }
    }
    return problems;
}

} // namespace springdrive::study
