// SQLite: a connection, a statement, a transaction. All errors are InputErrors.
#pragma once

#include <array>
#include <concepts>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

struct sqlite3;
struct sqlite3_stmt;

namespace springdrive::study {

/// Of the files that SQLite may keep beside a database.
inline constexpr std::array<const char *, 3> kJournalEndings{"-journal", "-wal", "-shm"};

/// How SQLite writes. Only the default keeps what was committed through a loss of power; tests show
/// that others do not.
///
/// A rollback journal, not a write-ahead log: between two trials the study is in one file, which
/// can be copied and read from write-protected media. EXTRA, not FULL: a commit is the deletion of
/// the journal, which is on the disk only after the folder has been synced.
struct DatabaseSettings {
    std::string vfs; ///< name of SQLite's interface to the system; empty: its own
    std::string journal_mode = "DELETE";
    std::string synchronous = "EXTRA";
};

enum class Access : std::uint8_t {
    read,
    write,  ///< of an existing file
    create, ///< of a file that is empty or does not exist
};

class Statement;

class Database {
public:
    /// @param shown  name of the file in messages
    /// @throw InputError if it cannot be opened so, and for a journal that is not its own
    Database(const std::filesystem::path &file, std::filesystem::path shown, Access access,
             const DatabaseSettings &settings);
    /// An empty one, of no file.
    [[nodiscard]] static Database in_memory(const std::filesystem::path &shown);
    /// A copy of all that is in it.
    [[nodiscard]] Database copy_in_memory() const;

    /// Runs statements without results.
    void run(const std::string &sql) const;

    [[nodiscard]] Statement prepare(std::string_view sql) const;

    /// The number that a statement gives, such as a pragma.
    [[nodiscard]] std::int64_t number(std::string_view sql) const;
    /// The text that a statement gives; empty without a row.
    [[nodiscard]] std::string text(std::string_view sql) const;

    [[nodiscard]] const std::filesystem::path &shown() const { return shown_; }

    /// @throw InputError "FILE: problem".
    [[noreturn]] void refuse(std::string_view problem) const;
    /// @throw InputError "FILE: is damaged (what); ...".
    [[noreturn]] void refuse_damage(std::string_view what) const;
    /// @throw InputError that says what SQLite's last error means for the file.
    [[noreturn]] void fail() const;

private:
    explicit Database(std::filesystem::path shown);

    struct Close {
        void operator()(sqlite3 *database) const noexcept;
    };
    std::filesystem::path shown_;
    std::unique_ptr<sqlite3, Close> database_;

    friend class Transaction;
};

/// Values are bound and read from left to right.
class Statement {
public:
    template <std::integral Integer> Statement &bind(Integer number) {
        return bind_integer(static_cast<std::int64_t>(number));
    }
    template <std::integral Integer> Statement &bind(const std::optional<Integer> &number) {
        return number ? bind(*number) : bind_null();
    }
    Statement &bind(std::string_view text);
    Statement &bind(double number); ///< NULL for a NaN
    Statement &bind(const std::optional<double> &number) {
        return number ? bind(*number) : bind_null();
    }
    Statement &bind_null();

    /// Makes the next row the current one; false after the last: values can then be bound anew.
    [[nodiscard]] bool next();
    /// Runs a statement without results, to its end.
    void run();

    // Of the current row. What is of another type is damage, and refused as such.
    [[nodiscard]] std::int64_t integer();
    [[nodiscard]] double real();
    [[nodiscard]] std::string text();
    void skip(int columns) { column_ += columns; }
    [[nodiscard]] bool is_text() const; ///< of the next column
    [[nodiscard]] bool is_null() const; ///< of the next column
    /// @throw InputError that the file is damaged, and how it can be seen
    [[noreturn]] void refuse(std::string_view what) const { database_->refuse_damage(what); }

private:
    friend class Database;
    Statement(const Database &database, sqlite3_stmt *statement);

    Statement &bind_integer(std::int64_t number);
    [[nodiscard]] int next_column(int type);

    struct Finalize {
        void operator()(sqlite3_stmt *statement) const noexcept;
    };
    const Database *database_;
    std::unique_ptr<sqlite3_stmt, Finalize> statement_;
    int bound_ = 0;
    int column_ = 0;
};

/// Rolled back unless committed.
class Transaction {
public:
    enum class Kind : std::uint8_t { read, write };
    Transaction(const Database &database, Kind kind);
    ~Transaction();
    Transaction(const Transaction &) = delete;
    Transaction &operator=(const Transaction &) = delete;

    void commit();

private:
    const Database &database_;
    bool is_open_ = true;
};

} // namespace springdrive::study
