// TOML files read without mercy: every key must be there, be of its type, lie in its range, and
// be known; whatever is not so is refused with the file, the line, the key and what is allowed.
#pragma once

#include "base/vector.h"

#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <string_view>

namespace springdrive {

/// What a number may be. Bounds are inclusive.
struct NumberRange {
    double lowest = -std::numeric_limits<double>::max();
    double highest = std::numeric_limits<double>::max();
};

/// One table of a TOML file. Every reader throws InputError as described above.
class StrictTomlTable {
public:
    /// Reads the root table of a file.
    [[nodiscard]] static StrictTomlTable read(const std::filesystem::path &file);

    /// The same of a text; complaints name it as `file`.
    [[nodiscard]] static StrictTomlTable parse(const std::string &text,
                                               const std::filesystem::path &file);

    /// Whether a key is there, for those that need not be. Does not count as asking for it.
    [[nodiscard]] bool has(std::string_view key) const;

    [[nodiscard]] std::string text(std::string_view key);
    [[nodiscard]] double number(std::string_view key, NumberRange range = {});
    [[nodiscard]] int integer(std::string_view key, int lowest, int highest);
    [[nodiscard]] Vector3 vector(std::string_view key, NumberRange range_of_each = {});
    [[nodiscard]] StrictTomlTable table(std::string_view key);

    /// Calls `read_one` once for [key], or once for each of the `count` tables [[key]].
    /// Returns how many there were: 1 or `count`.
    int tables(std::string_view key, int count,
               const std::function<void(int, StrictTomlTable &)> &read_one);

    /// Refuses the table if it holds a key that was never asked for. Call when all is read.
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
