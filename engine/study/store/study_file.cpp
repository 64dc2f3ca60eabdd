#include "engine/study/store/study_file.h"

#include "base/input_error.h"
#include "base/input_file.h"
#include "base/new_file.h"
#include "base/sha256.h"
#include "base/text.h"
#include "engine/study/store/rows.h"
#include "engine/study/store/study_contents.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>

namespace springdrive::study {

namespace {

const std::string kRecordsEnding = ".records";

std::string holder_text() {
    std::array<char, 256> host{};
    gethostname(host.data(), host.size() - 1);
    return fmt::format("process {} on {} since {}\n", getpid(), host.data(), utc_text(utc_now()));
}

std::string first_line(int descriptor) {
    std::array<char, 400> text{};
    const ssize_t count = pread(descriptor, text.data(), text.size(), 0);
    return one_line(
        std::string_view(text.data(), static_cast<std::size_t>(std::max<ssize_t>(count, 0))));
}

/// Whether the descriptor's file still has that name: its last holder removes it.
bool has_the_name(int descriptor, const std::filesystem::path &file) {
    struct stat opened {};
    struct stat named {};
    return fstat(descriptor, &opened) == 0 && lstat(file.c_str(), &named) == 0 &&
           opened.st_dev == named.st_dev && opened.st_ino == named.st_ino;
}

// A file of another version is refused, not changed: who made it has the program for it.

/// "SDST", by which the file is known as a study of this program (`PRAGMA application_id`).
constexpr std::int64_t kApplicationId = 0x53445354;

/// Of the tables and of the rows' SHA-256 (`PRAGMA user_version`).
constexpr std::int64_t kVersion = 2;

// The columns of each table are listed in rows.h, too; there with their C++ values.
//
// Numbers with fractions are in columns of type ANY, because SQLite reads a -0.0 in a REAL column
// back as 0.0. Child rows are numbered from 1. sha256 is of a row with its child rows:
// rows.cpp.
constexpr const char *kTables = R"(
CREATE TABLE study (
    id INTEGER PRIMARY KEY CHECK (id = 1),
    title TEXT NOT NULL,
    protocol TEXT NOT NULL,
    protocol_sha256 TEXT NOT NULL CHECK (length(protocol_sha256) = 64),
    created_utc TEXT NOT NULL CHECK (length(created_utc) = 24),
    software TEXT NOT NULL,
    records_folder TEXT NOT NULL CHECK (records_folder <> '' AND records_folder NOT GLOB '*/*'),
    removed_participants INTEGER NOT NULL CHECK (removed_participants >= 0),
    is_to_compact INTEGER NOT NULL CHECK (is_to_compact IN (0, 1)),
    sha256 TEXT NOT NULL CHECK (length(sha256) = 64)
) STRICT;
CREATE TABLE participant (
    id INTEGER PRIMARY KEY,
    code TEXT NOT NULL UNIQUE CHECK (length(code) BETWEEN 2 AND 7 AND code GLOB '[A-Z]*[0-9]'),
    number INTEGER NOT NULL UNIQUE CHECK (number >= 1),
    added_utc TEXT NOT NULL CHECK (length(added_utc) = 24),
    is_being_removed INTEGER NOT NULL CHECK (is_being_removed IN (0, 1)),
    sha256 TEXT NOT NULL CHECK (length(sha256) = 64)
) STRICT;
CREATE TABLE session (
    id INTEGER PRIMARY KEY,
    participant TEXT NOT NULL REFERENCES participant (code) ON DELETE CASCADE,
    started_utc TEXT NOT NULL CHECK (length(started_utc) = 24),
    ended_utc TEXT CHECK (length(ended_utc) = 24),
    ending TEXT CHECK (ending IN ('completed', 'stopped', 'left', 'device_lost', 'safety_trip',
                                  'failed', 'interrupted')),
    device_kind TEXT NOT NULL CHECK (device_kind IN ('simulated', 'emulated', 'usb')),
    device_name TEXT NOT NULL,
    device_serial TEXT NOT NULL,
    software TEXT NOT NULL,
    host TEXT NOT NULL,
    sha256 TEXT NOT NULL CHECK (length(sha256) = 64),
    UNIQUE (id, participant),
    CHECK (ended_utc IS NULL OR ending IS NOT NULL)
) STRICT;
CREATE TABLE session_fact (
    session INTEGER NOT NULL REFERENCES session ON DELETE CASCADE,
    number INTEGER NOT NULL,
    name TEXT NOT NULL CHECK (name <> ''),
    value ANY NOT NULL CHECK (typeof(value) IN ('real', 'text')),
    PRIMARY KEY (session, number)
) STRICT;
CREATE TABLE trial (
    id INTEGER PRIMARY KEY,
    participant TEXT NOT NULL REFERENCES participant (code) ON DELETE CASCADE,
    block INTEGER NOT NULL CHECK (block >= 1),
    position INTEGER NOT NULL CHECK (position >= 1),
    attempt INTEGER NOT NULL CHECK (attempt >= 1),
    session INTEGER NOT NULL,
    condition TEXT NOT NULL,
    track TEXT NOT NULL,
    is_practice INTEGER NOT NULL CHECK (is_practice IN (0, 1)),
    is_catch INTEGER NOT NULL CHECK (is_catch IN (0, 1)),
    is_presented_again INTEGER NOT NULL CHECK (is_presented_again IN (0, 1)),
    seed INTEGER NOT NULL,
    level_name TEXT NOT NULL,
    level ANY CHECK (typeof(level) IN ('real', 'null')),
    target INTEGER,
    response TEXT NOT NULL,
    chosen INTEGER,
    adjusted ANY,
    is_correct INTEGER CHECK (is_correct IN (0, 1)),
    response_time_s ANY CHECK (typeof(response_time_s) IN ('real', 'null')),
    at_utc TEXT NOT NULL CHECK (length(at_utc) = 24),
    software TEXT NOT NULL,
    missed_deadlines INTEGER NOT NULL CHECK (missed_deadlines >= 0),
    record_path TEXT CHECK (record_path <> '' AND record_path NOT GLOB '/*'),
    record_sha256 TEXT CHECK (length(record_sha256) = 64),
    repeats_block INTEGER,
    repeats_position INTEGER,
    repeats_attempt INTEGER,
    sha256 TEXT NOT NULL CHECK (length(sha256) = 64),
    UNIQUE (participant, block, position, attempt),
    UNIQUE (participant, repeats_block, repeats_position, repeats_attempt),
    FOREIGN KEY (session, participant) REFERENCES session (id, participant) ON DELETE CASCADE,
    FOREIGN KEY (participant, repeats_block, repeats_position, repeats_attempt)
        REFERENCES trial (participant, block, position, attempt) ON DELETE CASCADE,
    CHECK ((record_path IS NULL) = (record_sha256 IS NULL)),
    CHECK ((repeats_block IS NULL) = (repeats_position IS NULL)
           AND (repeats_block IS NULL) = (repeats_attempt IS NULL)),
    CHECK (CASE response
               WHEN 'none' THEN chosen IS NULL AND adjusted IS NULL
               WHEN 'chosen' THEN chosen >= 1 AND adjusted IS NULL
               WHEN 'yes_no' THEN chosen IN (0, 1) AND adjusted IS NULL
               WHEN 'adjusted' THEN chosen IS NULL AND typeof(adjusted) = 'real'
               ELSE 0 END)
) STRICT;
CREATE TABLE presentation (
    trial INTEGER NOT NULL REFERENCES trial ON DELETE CASCADE,
    number INTEGER NOT NULL,
    start_s ANY CHECK (typeof(start_s) IN ('real', 'null')),
    end_s ANY CHECK (typeof(end_s) IN ('real', 'null')),
    PRIMARY KEY (trial, number)
) STRICT;
CREATE TABLE stimulus_value (
    trial INTEGER NOT NULL REFERENCES trial ON DELETE CASCADE,
    number INTEGER NOT NULL,
    presentation INTEGER NOT NULL,
    name TEXT NOT NULL CHECK (name <> ''),
    intended ANY CHECK (typeof(intended) IN ('real', 'null')),
    delivered ANY CHECK (typeof(delivered) IN ('real', 'null')),
    PRIMARY KEY (trial, number),
    FOREIGN KEY (trial, presentation) REFERENCES presentation ON DELETE CASCADE
) STRICT;
CREATE TABLE tuning_value (
    trial INTEGER NOT NULL REFERENCES trial ON DELETE CASCADE,
    number INTEGER NOT NULL,
    name TEXT NOT NULL CHECK (name <> ''),
    value ANY NOT NULL CHECK (typeof(value) IN ('real', 'text')),
    PRIMARY KEY (trial, number)
) STRICT;
CREATE TABLE winding (
    trial INTEGER NOT NULL REFERENCES trial ON DELETE CASCADE,
    number INTEGER NOT NULL,
    temperature_degC ANY CHECK (typeof(temperature_degC) IN ('real', 'null')),
    PRIMARY KEY (trial, number)
) STRICT;
CREATE TABLE safety_event (
    trial INTEGER NOT NULL REFERENCES trial ON DELETE CASCADE,
    number INTEGER NOT NULL,
    time_s ANY CHECK (typeof(time_s) IN ('real', 'null')),
    text TEXT NOT NULL,
    PRIMARY KEY (trial, number)
) STRICT;
CREATE TABLE mark (
    trial INTEGER NOT NULL REFERENCES trial ON DELETE CASCADE,
    number INTEGER NOT NULL,
    reason TEXT NOT NULL CHECK (reason <> ''),
    PRIMARY KEY (trial, number)
) STRICT;
CREATE TABLE note (
    id INTEGER PRIMARY KEY,
    participant TEXT REFERENCES participant (code) ON DELETE CASCADE,
    session INTEGER,
    at_utc TEXT NOT NULL CHECK (length(at_utc) = 24),
    kind TEXT NOT NULL CHECK (kind <> ''),
    text TEXT NOT NULL,
    sha256 TEXT NOT NULL CHECK (length(sha256) = 64),
    FOREIGN KEY (session, participant) REFERENCES session (id, participant) ON DELETE CASCADE,
    CHECK (session IS NULL OR participant IS NOT NULL)
) STRICT;
CREATE TABLE answer (
    id INTEGER PRIMARY KEY,
    participant TEXT NOT NULL REFERENCES participant (code) ON DELETE CASCADE,
    session INTEGER NOT NULL,
    item TEXT NOT NULL CHECK (item <> ''),
    question TEXT NOT NULL CHECK (question <> ''),
    answer TEXT NOT NULL,
    at_utc TEXT NOT NULL CHECK (length(at_utc) = 24),
    sha256 TEXT NOT NULL CHECK (length(sha256) = 64),
    UNIQUE (session, item),
    FOREIGN KEY (session, participant) REFERENCES session (id, participant) ON DELETE CASCADE
) STRICT;
)";

/// All tables and indices with their SQL, in one text.
std::string tables_of(const Database &database) {
    return database.text(
        "SELECT coalesce(group_concat(line, char(10)), '') FROM (SELECT type || ' ' "
        "|| name || ': ' || coalesce(sql, '') AS line FROM sqlite_schema "
        "WHERE name NOT GLOB 'sqlite_stat*' ORDER BY type, name)");
}

/// @throw InputError if the file is no study, or of another version
void check_identity(const Database &database) {
    const std::int64_t version = database.number("PRAGMA user_version");
    if (database.number("PRAGMA application_id") != kApplicationId || version < 1) {
        database.refuse("is no study of springdrive, but another SQLite database; name a study "
                        "file");
    }
    if (version != kVersion) {
        database.refuse(fmt::format("is a study of version {}, and this program knows version {} "
                                    "only; open it with {} springdrive",
                                    version, kVersion,
                                    version > kVersion ? "a newer" : "an older"));
    }
}

/// Makes an empty database a study without rows, in one transaction.
void create_tables(const Database &database) {
    Transaction transaction(database, Transaction::Kind::write);
    database.run(kTables);
    database.run(fmt::format("PRAGMA application_id = {}; PRAGMA user_version = {}", kApplicationId,
                             kVersion));
    transaction.commit();
}

/// @throw InputError if SQLite or a comparison with the tables of a new study finds damage
/// @pre its identity was checked
void check_structure(const Database &database) {
    const std::string found = database.text("PRAGMA integrity_check(1)");
    if (found != "ok") {
        database.refuse_damage(found);
    }
    if (!database.text("SELECT \"table\" FROM pragma_foreign_key_check LIMIT 1").empty()) {
        database.refuse_damage("a row refers to one that is missing");
    }
    const Database model = Database::in_memory(database.shown());
    create_tables(model);
    if (tables_of(database) != tables_of(model)) {
        database.refuse_damage("its tables are not as springdrive made them");
    }
}

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

/// The names of what stands beside a study are longer than its own.
void check_length_of_name(const std::filesystem::path &file) {
    const std::filesystem::path name = resolved_name(file);
    const long known = pathconf(name.parent_path().c_str(), _PC_NAME_MAX);
    const std::size_t max_bytes = known > 0 ? static_cast<std::size_t>(known) : 255;
    const std::size_t needed =
        std::max(name.filename().string().size() + std::string_view(kJournalEndings[0]).size(),
                 file.stem().string().size() + kRecordsEnding.size());
    if (needed > max_bytes) {
        throw InputError(
            fmt::format("{}: its name is {} bytes too long: a journal and a folder of "
                        "records with longer names stand beside it; give a shorter one",
                        file.string(), needed - max_bytes));
    }
}

} // namespace

void sync(const std::filesystem::path &file_or_folder) {
    const int descriptor = open(file_or_folder.c_str(), O_RDONLY | O_CLOEXEC);
    const bool is_synced = descriptor >= 0 && fsync(descriptor) == 0;
    const int error = errno;
    if (descriptor >= 0) {
        close(descriptor);
    }
    // Some file systems cannot sync a folder, and do not need it.
    if (!is_synced && error != EINVAL) {
        throw InputError(file_or_folder.string() + ": cannot be written to the disk: " +
                         std::generic_category().message(error) + "; check the disk");
    }
}

void sync_folders(const std::filesystem::path &file, const std::filesystem::path &top) {
    std::filesystem::path folder = file;
    do {
        folder = folder.parent_path();
        sync(folder);
    } while (folder != top && folder.has_relative_path());
}

void check_own_file(const std::filesystem::path &file) {
    struct stat found {};
    if (lstat(file.c_str(), &found) == 0 && (!S_ISREG(found.st_mode) || found.st_nlink > 1)) {
        throw InputError(file.string() + ": is a link or no ordinary file, which springdrive never "
                                         "makes of that name; move it away");
    }
}

void remove_folder(const std::filesystem::path &folder) {
    std::error_code error;
    if (!std::filesystem::exists(std::filesystem::symlink_status(folder, error))) {
        return;
    }
    std::filesystem::remove_all(folder, error);
    if (error) {
        throw InputError(folder.string() + ": cannot be removed: " + error.message() +
                         "; make it writable and repeat");
    }
    sync(folder.parent_path());
}

StudyLock::StudyLock(const std::filesystem::path &study, const std::filesystem::path &shown)
    : file_(study.string() + std::string(kEnding)) {
    do {
        if (descriptor_ >= 0) {
            close(descriptor_);
        }
        check_own_file(file_); // it is overwritten
        descriptor_ = open(file_.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC,
                           creation_mode(Readers::owner));
        if (descriptor_ < 0) {
            throw InputError(fmt::format("{}: cannot be locked for writing: {}; its folder must be "
                                         "writable",
                                         shown.string(), std::generic_category().message(errno)));
        }
        if (flock(descriptor_, LOCK_EX | LOCK_NB) != 0) {
            const int error = errno;
            const std::string holder = first_line(descriptor_);
            close(descriptor_);
            throw InputError(
                error == EWOULDBLOCK
                    ? fmt::format("{}: is open for writing already, by {}; end that one first",
                                  shown.string(), holder.empty() ? "another program" : holder)
                    : fmt::format("{}: cannot be locked for writing: {}; move it to a local disk",
                                  shown.string(), std::generic_category().message(error)));
        }
    } while (!has_the_name(descriptor_, file_));
    const std::string text = holder_text();
    // A help for people: the lock holds without it, on a full disk for example.
    [[maybe_unused]] const bool is_written =
        ftruncate(descriptor_, 0) == 0 && pwrite(descriptor_, text.data(), text.size(), 0) > 0;
}

StudyLock::~StudyLock() {
    unlink(file_.c_str());
    close(descriptor_);
}

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
    check_length_of_name(file);
    check_name_of_new(file);
    const std::string records_folder = file.stem().string() + kRecordsEnding;
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
