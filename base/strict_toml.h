// Strict reader of TOML files: every required key must be present, of the right type and in range,
// and every key must be known; anything else is rejected with the file, the line, the key and what
// is allowed.
#pragma once

#include "base/field.h"
#include "base/vector.h"

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive {

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
    /// The same; the key is known from now on, see `refuse_unknown_keys`.
    [[nodiscard]] bool has_optional(std::string_view key);

    /// @param bytes  of its length; from 1 on, some of it must be visible
    [[nodiscard]] std::string text(std::string_view key, NumberRange bytes = {});
    [[nodiscard]] double number(std::string_view key, NumberRange range = {});
    [[nodiscard]] int integer(std::string_view key, int minimum, int maximum);
    [[nodiscard]] bool flag(std::string_view key);
    /// The number of the one of `names` that is there.
    [[nodiscard]] std::size_t choice(std::string_view key, std::span<const std::string_view> names);
    /// The numbers of those of `names` that are in a list, which may be empty.
    [[nodiscard]] std::vector<std::size_t> choices(std::string_view key,
                                                   std::span<const std::string_view> names);
    [[nodiscard]] Vector3 vector(std::string_view key, NumberRange range_of_each = {});
    /// A list of any length, up to `most`.
    [[nodiscard]] std::vector<double> numbers(std::string_view key, NumberRange range_of_each,
                                              std::size_t most);
    [[nodiscard]] std::vector<std::string> texts(std::string_view key, std::size_t most);
    [[nodiscard]] StrictTomlTable table(std::string_view key);

    /// Calls `read_one` once for [key], or once for each of the `count` tables [[key]].
    /// Returns the number of tables: 1 or `count`.
    int tables(std::string_view key, int count,
               const std::function<void(int, StrictTomlTable &)> &read_one);

    /// Calls `read_one` for each of the tables [[key]], of which there are one to `most`.
    void rows(std::string_view key, std::size_t most,
              const std::function<void(StrictTomlTable &)> &read_one);

    /// Rejects the table if it has a key that was never read, naming the nearest one that would be.
    /// Call after reading everything.
    void refuse_unknown_keys() const;

    /// An InputError about one key: "FILE:LINE: NAME `problem`".
    [[noreturn]] void refuse(std::string_view key, const std::string &problem) const;

    ~StrictTomlTable();
    StrictTomlTable(StrictTomlTable &&) noexcept;
    StrictTomlTable &operator=(StrictTomlTable &&) noexcept;

private:
    struct Contents;
    explicit StrictTomlTable(std::unique_ptr<Contents> contents);
    [[nodiscard]] StrictTomlTable row(std::string_view key, std::size_t index) const;
    std::unique_ptr<Contents> contents_;
};

} // namespace springdrive
