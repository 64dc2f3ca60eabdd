// Text for other readers, quoted by the rules of each.
#pragma once

#include <string>
#include <string_view>

namespace springdrive {

/// What begins with = + - @, also of full width, with a tab or a line end, and is no number, has a
/// ' in front, as people type it there; so has what begins so after other '. For tables that are
/// opened with a spreadsheet, which runs what begins like a formula.
[[nodiscard]] std::string guard_formula(std::string_view text);

/// A cell of a CSV file: guarded, and in quotes if needed (RFC 4180).
[[nodiscard]] std::string csv_cell(std::string_view text);

/// The fewest digits that read back as the same number; empty if infinite or not a number.
[[nodiscard]] std::string csv_cell(double number);

/// A cell of a TSV file as in BIDS: on one line, guarded, in quotes if it has some itself; "n/a" if
/// empty.
[[nodiscard]] std::string tsv_cell(std::string_view text);

/// A string in gnuplot's language. A line end becomes a blank.
///
/// gnuplot does not know doubled quotes in a CSV file: a comma behind a quote ends the cell, a line
/// end the row, and a row that begins with # is left out. What is drawn is best passed as numbers.
[[nodiscard]] std::string gnuplot_string(std::string_view text);

/// Whether each byte is part of a character as Unicode defines UTF-8 (its table 3-7): none is cut,
/// longer than need be, one half of a pair, or beyond the last.
[[nodiscard]] bool is_utf8(std::string_view text);

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

/// Text between the tags of SVG. Control characters are left out.
[[nodiscard]] std::string xml_text(std::string_view text);

/// A JSON document, a value of nlohmann's library. Bytes that are no UTF-8, as names of files may
/// hold, are replaced.
/// @param indent  -1: on one line
template <typename Json> [[nodiscard]] std::string json_text(const Json &json, int indent = 2) {
    return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

} // namespace springdrive
