// A table: columns with their meaning and rows of values, printed for people and for programs.
#pragma once

#include <concepts>
#include <cstdint>
#include <iosfwd>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace springdrive {

/// A value. True is 1, false is 0; a number that is infinite or not a number is not known.
class Cell {
public:
    Cell() = default; ///< not known, or does not apply
    Cell(double number) : kind_(Kind::real), number_(number) {}
    template <std::integral Integer>
    Cell(Integer number) : kind_(Kind::whole), text_(std::to_string(number)) {}
    Cell(std::string text) : kind_(Kind::text), text_(std::move(text)) {}
    Cell(std::string_view text) : Cell(std::string(text)) {}
    Cell(const char *text) : Cell(std::string(text)) {}
    template <typename Value>
    Cell(const std::optional<Value> &value) : Cell(value ? Cell(*value) : Cell()) {}

    /// Text that stands where numbers do: at the right. "1.2 (1.1 to 1.3)"
    [[nodiscard]] static Cell like_number(std::string text);

    [[nodiscard]] bool is_empty() const;
    [[nodiscard]] bool is_number() const { return kind_ == Kind::whole || kind_ == Kind::real; }

    /// Its text; empty if it is not known.
    /// @param format  of real numbers, in the language of fmt: ".4g"; empty: the fewest digits that
    ///                read back as the same number
    [[nodiscard]] std::string text(std::string_view format) const;

private:
    enum class Kind : std::uint8_t { none, text, whole, real };

    Kind kind_ = Kind::none;
    double number_ = 0.0; ///< if real
    std::string text_;    ///< else
};

struct Column {
    std::string name; ///< for programs one word that ends in the unit; for people one or more lines
    std::string format{}; ///< of real numbers, see `Cell::text`
    std::string meaning{};
    std::string unit{};                                        ///< as in BIDS; empty: none
    std::vector<std::pair<std::string, std::string>> levels{}; ///< values with their meaning
};

struct Table {
    std::vector<Column> columns;
    std::vector<std::vector<Cell>> rows{}; ///< of a cell a column

    /// Without rows.
    /// @param columns  their names, some with a format: "who,trials,force_N:.3g"
    /// @param format   of the others
    [[nodiscard]] static Table with_columns(std::string_view columns, std::string_view format = "");
};

/// A line of names and a line a row (RFC 4180). What is not known is an empty cell.
void write_csv(std::ostream &out, const Table &table);

/// The same with tabs, as in BIDS; what is not known is "n/a".
void write_tsv(std::ostream &out, const Table &table);

/// For people: columns as wide as what is in them, those with numbers at the right, the others at
/// the left; what is not known is a dash.
void write_text(std::ostream &out, const Table &table);

/// For documents, in Markdown: aligned likewise.
void write_markdown(std::ostream &out, const Table &table);

} // namespace springdrive
