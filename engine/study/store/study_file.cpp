#include "engine/study/store/study_file.h"

#include "engine/study/store/durable_files.h"
#include "engine/study/store/rows.h"
#include "engine/study/store/schema.h"
#include "engine/study/store/study_lock.h"
#include "engine/study/store/study_store.h"
#include "engine/study/store/trial_checks.h"

#include "base/input_error.h"
#include "base/input_file.h"
#include "base/new_file.h"
#include "base/sha256.h"

namespace springdrive::study {

namespace {

constexpr std::uintmax_t kMaxBytes = std::uintmax_t{1} << 36U; ///< 64 GiB

std::string sha256_of(std::string_view text) {
    Sha256 sha256;
    sha256.add(text.data(), text.size()); // the bytes alone, as sha256sum
    return sha256.hex();
}

/// A journal of an earlier file would be played back into a new one of its name.
void check_name_of_new(const std::filesystem::path &file) {
    std::error_code ignored;
    if (std::filesystem::exists(file, ignored)) {
        throw InputError(file.string() +
                         ": exists already; a study is never replaced: give another name");
    }
    for (const char *const ending : kJournalEndings) {
        const std::string left = file.string() + ending;
        if (std::filesystem::exists(left, ignored)) {
            throw InputError(left + ": belongs to a study that was here; move it to that study, or "
                                    "give another name");
        }
    }
}

} // namespace

std::vector<std::filesystem::path> files_beside(const std::filesystem::path &file) {
    const std::string resolved = resolved_name(file).string();
    std::vector<std::filesystem::path> all{resolved + std::string(StudyLock::kEnding)};
    for (const char *const ending : kJournalEndings) {
        all.emplace_back(resolved + ending);
    }
    return all;
}

std::filesystem::path name_of_existing(const std::filesystem::path &file) {
    check_input_file(file, "a study file", kMaxBytes);
    std::error_code ignored;
    if (!std::filesystem::exists(file, ignored)) {
        throw InputError(file.string() + ": does not exist; name a study file");
    }
    if (std::filesystem::file_size(file, ignored) == 0) {
        throw InputError(file.string() + ": is empty, no study; name a study file");
    }
    return resolved_name(file);
}

Database open_to_write(const std::filesystem::path &file, const std::filesystem::path &shown,
                       const DatabaseSettings &settings) {
    Database database(file, shown, Access::write, settings);
    {
        const Transaction transaction(database, Transaction::Kind::read);
        check_identity(database);
        check_structure(database);
        static_cast<void>(read_contents(database)); // checks each row
    }
    return database;
}

void fill_new(const Database &database, const NewStudy &study, UtcTime now,
              const std::string &records_folder) {
    create_tables(database);
    StudyRow row;
    row.facts.title = study.title;
    row.facts.protocol = study.protocol;
    row.facts.protocol_sha256 = sha256_of(study.protocol);
    row.facts.created = now;
    row.facts.software = study.software;
    row.facts.records_folder = records_folder;
    Transaction transaction(database, Transaction::Kind::write);
    insert(database, row);
    transaction.commit();
}

void create_study(const std::filesystem::path &file, const NewStudy &study, UtcTime now) {
    check_name_of_new(file);
    const std::string records_folder = file.stem().string() + ".records";
    if (const std::string problem = validate_records_folder(records_folder); !problem.empty()) {
        throw InputError(file.string() + ": cannot be the name of a study: " + problem);
    }
    NewFile created(file, Readers::owner);
    {
        const Database database(created.temporary(), file, Access::create, {});
        fill_new(database, study, now, records_folder);
    }
    try {
        created.publish(Existing::keep);
    } catch (const InputError &) {
        check_name_of_new(file); // another program was faster
        throw;
    }
    sync(resolved_name(file).parent_path());
}

StudyContents read_study(const std::filesystem::path &file) {
    // Checks work on a copy in memory, so that a trial that is to be stored meanwhile waits no
    // longer than copying takes.
    const auto copied = [&] {
        const Database database(name_of_existing(file), file, Access::read, {});
        const Transaction transaction(database, Transaction::Kind::read);
        check_identity(database);
        return database.copy_in_memory();
    };
    const Database copy = copied();
    check_structure(copy);
    return read_contents(copy);
}

} // namespace springdrive::study
