#include "engine/study/store/database.h"

#include "engine/study/store/study_file.h"

#include "base/input_error.h"
#include "base/text.h"

#include <fmt/core.h>
#include <sqlite3.h>

#include <fstream>
#include <system_error>
#include <utility>

namespace springdrive::study {

namespace {

constexpr int kBusyTimeout_ms = 10'000; ///< with another program that reads or writes
constexpr const char *kReadable = "PRAGMA temp_store = MEMORY; PRAGMA trusted_schema = OFF;"
                                  "PRAGMA cell_size_check = ON; PRAGMA mmap_size = 0;";

std::string damage_text(std::string_view what) {
    return fmt::format("is damaged ({}); nothing was changed; continue with a copy of it", what);
}

/// In which an error of input or output occurred.
std::string_view activity_of(int code) {
    switch (code) {
    case SQLITE_IOERR_READ:
    case SQLITE_IOERR_SHORT_READ:
        return "reading";
    case SQLITE_IOERR_FSYNC:
    case SQLITE_IOERR_DIR_FSYNC:
        return "waiting for the data to be on it";
    case SQLITE_IOERR_DELETE:
        return "deleting the journal";
    default:
        return "writing";
    }
}

/// What the codes of SQLite mean for the file, and what to do.
std::string meaning_of(int code, const std::string &system, const std::string &said) {
    if (code == SQLITE_READONLY_ROLLBACK || code == SQLITE_READONLY_RECOVERY) {
        return "was left in the midst of a write, which cannot be undone while it is "
               "write-protected; copy it to another folder, with its journal";
    }
    if (code == SQLITE_READONLY_DBMOVED) {
        return "was moved or deleted while it was open: nothing of this was stored; put it back, "
               "or a copy of it, and repeat";
    }
    switch (code & 0xff) {
    case SQLITE_NOTADB:
        return "is no study: it is not an SQLite database; name a study file";
    case SQLITE_CORRUPT:
        return damage_text(said);
    case SQLITE_FULL:
        return "the disk is full: nothing of this was stored, all before it is; free disk space "
               "and repeat it";
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
        return "another program has been using it for ten seconds; end that one and repeat";
    case SQLITE_READONLY:
        return "is write-protected, or its folder is; change that or copy it elsewhere";
    case SQLITE_CANTOPEN:
        return "cannot be opened" + (system.empty() ? std::string() : ": " + system) +
               "; check it, its folder and permissions";
    case SQLITE_IOERR:
        return fmt::format("the disk failed in {}; check it and its free space, and repeat",
                           activity_of(code));
    default:
        return said;
    }
}

/// Whether a rollback journal ends in the name of another file, as those of transactions in several
/// databases do. When SQLite has played such a journal back, it deletes that file, whatever it is.
/// https://www.sqlite.org/fileformat.html, "The Rollback Journal"
bool names_another_file(const std::filesystem::path &journal) {
    constexpr std::string_view kMagic("\xd9\xd5\x05\xf9\x20\xa1\x63\xd7", 8);
    constexpr std::streamoff kTail = 16; // length and checksum of the name, magic
    std::ifstream file(journal, std::ios::binary);
    std::array<char, kTail> tail{};
    return file.seekg(-kTail, std::ios::end) && file.read(tail.data(), kTail) &&
           std::string_view(tail.data(), kTail).ends_with(kMagic);
}

/// Journals that came with a study from elsewhere.
void check_journals(const std::filesystem::path &file) {
    for (const char *const ending : kJournalEndings) {
        const std::filesystem::path journal = file.string() + ending;
        check_own_file(journal);
        if (names_another_file(journal)) {
            throw InputError(journal.string() + ": names another file, which would be deleted, as "
                                                "no study's journal does; move it away");
        }
    }
}

} // namespace

void Database::Close::operator()(sqlite3 *database) const noexcept { sqlite3_close_v2(database); }

Database::Database(std::filesystem::path shown) : shown_(std::move(shown)) {
    sqlite3 *opened = nullptr;
    const int result =
        sqlite3_open_v2(":memory:", &opened, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, nullptr);
    database_.reset(opened);
    if (result != SQLITE_OK) {
        fail();
    }
    run(std::string(kReadable) + "PRAGMA foreign_keys = ON");
}

Database::Database(const std::filesystem::path &file, std::filesystem::path shown, Access access,
                   const DatabaseSettings &settings)
    : shown_(std::move(shown)) {
    check_journals(file);
    // Reading opens it for writing where it can: a journal that a killed program left has to be
    // played back first.
    const int flags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_EXRESCODE |
                      (access == Access::create ? SQLITE_OPEN_CREATE : 0);
    sqlite3 *opened = nullptr;
    const int result = sqlite3_open_v2(file.c_str(), &opened, flags,
                                       settings.vfs.empty() ? nullptr : settings.vfs.c_str());
    database_.reset(opened);
    if (result != SQLITE_OK) {
        fail();
    }
    sqlite3_db_config(opened, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
    sqlite3_busy_timeout(opened, kBusyTimeout_ms);
    run(kReadable);
    if (access == Access::read) {
        run("PRAGMA query_only = ON");
        return;
    }
    if (sqlite3_db_readonly(opened, "main") == 1) {
        refuse(meaning_of(SQLITE_READONLY, {}, {}));
    }
    run("PRAGMA foreign_keys = ON; PRAGMA secure_delete = ON; PRAGMA synchronous = " +
        settings.synchronous);
    const std::string mode = text("PRAGMA journal_mode = " + settings.journal_mode);
    if (sqlite3_stricmp(mode.c_str(), settings.journal_mode.c_str()) != 0) {
        refuse("its journal cannot be kept in the mode " + settings.journal_mode +
               "; copy it to a local disk");
    }
}

Database Database::in_memory(const std::filesystem::path &shown) { return Database(shown); }

Database Database::copy_in_memory() const {
    Database copy(shown_);
    sqlite3_backup *const backup =
        sqlite3_backup_init(copy.database_.get(), "main", database_.get(), "main");
    if (backup == nullptr) {
        copy.fail();
    }
    const int result = sqlite3_backup_step(backup, -1);
    sqlite3_backup_finish(backup);
    if (result != SQLITE_DONE) {
        copy.fail();
    }
    return copy;
}

void Database::run(const std::string &sql) const {
    if (sqlite3_exec(database_.get(), sql.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK) {
        fail();
    }
}

Statement Database::prepare(std::string_view sql) const {
    sqlite3_stmt *statement = nullptr;
    if (sqlite3_prepare_v2(database_.get(), sql.data(), static_cast<int>(sql.size()), &statement,
                           nullptr) != SQLITE_OK) {
        fail();
    }
    return {*this, statement};
}

std::int64_t Database::number(std::string_view sql) const {
    Statement statement = prepare(sql);
    return statement.next() ? statement.integer() : 0;
}

std::string Database::text(std::string_view sql) const {
    Statement statement = prepare(sql);
    return statement.next() ? statement.text() : std::string();
}

void Database::refuse(std::string_view problem) const {
    throw InputError(fmt::format("{}: {}", shown_.string(), one_line(problem)));
}

void Database::refuse_damage(std::string_view what) const { refuse(damage_text(what)); }

void Database::fail() const {
    const int code = sqlite3_extended_errcode(database_.get());
    const int system = sqlite3_system_errno(database_.get());
    refuse(meaning_of(code, system == 0 ? "" : std::generic_category().message(system),
                      sqlite3_errmsg(database_.get())));
}

void Statement::Finalize::operator()(sqlite3_stmt *statement) const noexcept {
    sqlite3_finalize(statement);
}

Statement::Statement(const Database &database, sqlite3_stmt *statement)
    : database_(&database), statement_(statement) {}

Statement &Statement::bind_integer(std::int64_t number) {
    sqlite3_bind_int64(statement_.get(), ++bound_, number);
    return *this;
}

Statement &Statement::bind(double number) {
    sqlite3_bind_double(statement_.get(), ++bound_, number); // which stores a NaN as NULL
    return *this;
}

Statement &Statement::bind(std::string_view text) {
    const char *const bytes = text.empty() ? "" : text.data(); // a null pointer would be NULL
    sqlite3_bind_text64(statement_.get(), ++bound_, bytes, text.size(), SQLITE_TRANSIENT,
                        SQLITE_UTF8);
    return *this;
}

Statement &Statement::bind_null() {
    sqlite3_bind_null(statement_.get(), ++bound_);
    return *this;
}

bool Statement::next() {
    column_ = 0;
    const int result = sqlite3_step(statement_.get());
    if (result == SQLITE_ROW) {
        return true;
    }
    if (result != SQLITE_DONE) {
        database_->fail();
    }
    sqlite3_reset(statement_.get());
    bound_ = 0;
    return false;
}

void Statement::run() {
    while (next()) {
    }
}

int Statement::next_column(int type) {
    if (sqlite3_column_type(statement_.get(), column_) != type) {
        refuse("a value of another type");
    }
    return column_++;
}

std::int64_t Statement::integer() {
    return sqlite3_column_int64(statement_.get(), next_column(SQLITE_INTEGER));
}

double Statement::real() {
    return sqlite3_column_double(statement_.get(), next_column(SQLITE_FLOAT));
}

std::string Statement::text() {
    const int column = next_column(SQLITE_TEXT);
    const unsigned char *const bytes = sqlite3_column_text(statement_.get(), column);
    if (bytes == nullptr) {
        database_->fail();
    }
    return {reinterpret_cast<const char *>(bytes),
            static_cast<std::size_t>(sqlite3_column_bytes(statement_.get(), column))};
}

bool Statement::is_text() const {
    return sqlite3_column_type(statement_.get(), column_) == SQLITE_TEXT;
}

bool Statement::is_null() const {
    return sqlite3_column_type(statement_.get(), column_) == SQLITE_NULL;
}

Transaction::Transaction(const Database &database, Kind kind) : database_(database) {
    database_.run(kind == Kind::write ? "BEGIN IMMEDIATE" : "BEGIN");
}

Transaction::~Transaction() {
    // Some errors have rolled it back already.
    if (is_open_ && sqlite3_get_autocommit(database_.database_.get()) == 0) {
        sqlite3_exec(database_.database_.get(), "ROLLBACK", nullptr, nullptr, nullptr);
    }
}

void Transaction::commit() {
    database_.run("COMMIT");
    is_open_ = false;
}

} // namespace springdrive::study
