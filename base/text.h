// Texts and numbers: as parts of messages, read from a text, the nearest of mistyped names, and
// quoted by the rules of each reader.
#pragma once

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <numeric>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive {

/// `text` on one line: control characters and line ends become single spaces, the ends are
/// trimmed, and what is longer than `max_length` bytes is cut (never within a UTF-8 character).
[[nodiscard]] std::string one_line(std::string_view text, std::size_t max_length = 300);

/// In single quotes, on one line, with all its blanks; at most 80 bytes of it.
[[nodiscard]] std::string in_quotes(std::string_view text);

/// Why people could not tell a name from another by eye: it has a control character or line end, or
/// begins or ends with a blank or another character that is not seen. Empty if they can.
[[nodiscard]] std::string validate_name(std::string_view name);

/// The shortest text that reads back as `number`.
[[nodiscard]] std::string shortest_text(double number);

/// All of a text as a number; nothing for any other text, or a number that the type cannot hold.
template <typename Number> [[nodiscard]] std::optional<Number> number_in(std::string_view text) {
    Number number{};
    const char *const end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, number);
    return error == std::errc() && stop == end ? std::optional(number) : std::nullopt;
}

/// Levenshtein distance of two names: the number of letters to insert, delete or change.
[[nodiscard]] inline std::size_t letters_between(std::string_view a, std::string_view b) {
    std::vector<std::size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (const char letter : a) {
        std::size_t diagonal = row[0]++;
        for (std::size_t j = 1; j < row.size(); ++j) {
            const std::size_t changed = diagonal + (letter == b[j - 1] ? 0 : 1);
            diagonal = row[j];
            row[j] = std::min({changed, row[j] + 1, row[j - 1] + 1});
        }
    }
    return row.back();
}

/// For messages: sorts names by their distance to `typed`, the nearest first; equally near ones
/// keep their order.
/// @param name_of  the name of an element, as text
template <typename Element, typename NameOf>
void sort_by_similarity(std::vector<Element> &elements, std::string_view typed,
                        const NameOf &name_of) {
    constexpr std::size_t kMaxCompared = 100;
    const std::string_view compared = typed.substr(0, kMaxCompared);
    std::ranges::stable_sort(elements, {}, [&](const Element &element) {
        return letters_between(compared, name_of(element));
    });
}

// Text for other readers, quoted by the rules of each.

/// What begins with = + - @, also of full width, with a tab or a line end, and is no number, has a
/// ' in front, as people type it there; so has what begins so after other '. For tables that are
/// opened with a spreadsheet, which runs what begins like a formula.
[[nodiscard]] std::string guard_formula(std::string_view text);

/// A cell of a CSV file: guarded, and in quotes if needed (RFC 4180).
[[nodiscard]] std::string csv_cell(std::string_view text);

/// The fewest digits that read back as the same number; empty if infinite or not a number.
[[nodiscard]] std::string csv_cell(double number);

/// A cell of a TSV file as in BIDS: guarded, in quotes if it has some itself; "n/a" if nothing of
/// it can be seen. Control characters become blanks; those at its ends go.
[[nodiscard]] std::string tsv_cell(std::string_view text);

/// A string in gnuplot's language. Control characters become blanks, and what SVG cannot have, the
/// two non-characters of XML, becomes U+FFFD.
///
/// gnuplot does not know doubled quotes in a CSV file: a comma behind a quote ends the cell, a line
/// end the row, and a row that begins with # is left out. What is drawn is best passed as numbers.
[[nodiscard]] std::string gnuplot_string(std::string_view text);

/// Whether each byte is part of a character as Unicode defines UTF-8 (its table 3-7): none is cut,
/// longer than need be, one half of a pair, or beyond the last.
[[nodiscard]] bool is_utf8(std::string_view text);

/// With each byte that is part of no such character, and each control character, as "\xff": of
/// names of files, in messages.
[[nodiscard]] std::string as_utf8(std::string_view text);

/// A string of a TOML file, on one line. @pre it is UTF-8, as all of TOML
[[nodiscard]] std::string toml_string(std::string_view text);

/// A floating-point number of a TOML file, which reads back as the same. @pre finite
[[nodiscard]] std::string toml_number(double number);

/// A list of strings.
template <typename Texts> [[nodiscard]] std::string toml_list(const Texts &texts) {
    std::string list;
    for (const auto &text : texts) {
        list += (list.empty() ? "" : ", ") + toml_string(text);
    }
    return '[' + list + ']';
}

/// Text between the tags of SVG. Control characters are left out; the two non-characters of XML
/// become U+FFFD.
[[nodiscard]] std::string xml_text(std::string_view text);

/// A JSON document, a value of nlohmann's library. Bytes that are no UTF-8, as names of files may
/// hold, are replaced.
/// @param indent  -1: on one line
template <typename Json> [[nodiscard]] std::string json_text(const Json &json, int indent = 2) {
    return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

} // namespace springdrive
