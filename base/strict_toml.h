// Strict reader of TOML files: every required key must be present, of the right type and in range,
// and every key must be known; anything else is rejected with the file, the line, the key and what
// is allowed.
#pragma once

#include "base/vector.h"

#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <string_view>

namespace springdrive {

/// The allowed range of a number. Bounds are inclusive.
struct NumberRange {
    double minimum = -std::numeric_limits<double>::max();
    double maximum = std::numeric_limits<double>::max();
};

/// One table of a TOML file. Every reader throws InputError as described above.
class StrictTomlTable {
public:
    /// Reads the root table of a file.
    [[nodiscard]] static StrictTomlTable read(const std::filesystem::path &file);

    /// Parses a text; error messages refer to it as `file`.
    [[nodiscard]] static StrictTomlTable parse(const std::string &text,
                                               const std::filesystem::path &file);

    /// Whether an optional key is present. Does not mark it as read.
    [[nodiscard]] bool has(std::string_view key) const;

    [[nodiscard]] std::string text(std::string_view key);
    [[nodiscard]] double number(std::string_view key, NumberRange range = {});
    [[nodiscard]] int integer(std::string_view key, int minimum, int maximum);
    [[nodiscard]] Vector3 vector(std::string_view key, NumberRange range_of_each = {});
    [[nodiscard]] StrictTomlTable table(std::string_view key);

    /// Calls `read_one` once for [key], or once for each of the `count` tables [[key]].
    /// Returns the number of tables: 1 or `count`.
    int tables(std::string_view key, int count,
               const std::function<void(int, StrictTomlTable &)> &read_one);

    /// Rejects the table if it has a key that was never read. Call after reading everything.
    void refuse_unknown_keys() const;

    /// An InputError about one key: "FILE:LINE: NAME `problem`".
    [[noreturn]] void refuse(std::string_view key, const std::string &problem) const;

    ~StrictTomlTable();
    StrictTomlTable(StrictTomlTable &&) noexcept;
    StrictTomlTable &operator=(StrictTomlTable &&) noexcept;

private:
    struct Contents;
    explicit StrictTomlTable(std::unique_ptr<Contents> contents);
    std::unique_ptr<Contents> contents_;
};

} // namespace springdrive
