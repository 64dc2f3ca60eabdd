// What persons make of texts: which names they take for one, and files that they open.
#pragma once

#include <iosfwd>
#include <string>
#include <string_view>

namespace springdrive {

struct Table;

/// Whether persons take two names, in UTF-8, for one: they are the same but for blanks and what is
/// not seen, for case, or for how Unicode puts an accented letter together: as one character, or as
/// a letter with marks behind it. A letter with marks is like any other that is one character and
/// not ASCII, as only a table of all letters could tell which it is.
[[nodiscard]] bool look_alike(std::string_view a, std::string_view b);

/// All of a CSV file that persons open: behind a byte-order mark if there are letters beyond ASCII,
/// which Excel takes for Latin-1 without one. Not for files that programs alone read: base R and
/// numpy take the mark for a part of the first name.
[[nodiscard]] std::string csv_for_persons(std::string csv);

/// A table as `csv_for_persons`.
void write_csv_for_persons(std::ostream &out, const Table &table);

} // namespace springdrive
