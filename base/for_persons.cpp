#include "base/for_persons.h"

#include "base/table.h"

#include <algorithm>
#include <clocale>
#include <cwchar>
#include <cwctype>
#include <ostream>
#include <sstream>
#include <vector>

namespace springdrive {

namespace {

/// A letter as it is seen.
struct SeenLetter {
    wchar_t base = 0; ///< without case
    bool is_ascii = false;
    std::wstring marks{}; ///< on it, by their numbers
};

bool is_like(const SeenLetter &a, const SeenLetter &b) {
    const SeenLetter &whole = a.marks.size() < b.marks.size() ? a : b;
    return a.marks.size() == b.marks.size() ? a.base == b.base && a.marks == b.marks
                                            : !whole.is_ascii;
}

/// Takes up no room, but is no mark of the letter before it: soft hyphen, joiners, directions,
/// byte-order mark; or it is a blank that does not break.
bool is_unseen(wchar_t c) {
    const auto is_from_to = [c](wchar_t first, wchar_t last) { return first <= c && c <= last; };
    return c == 0xA0 || c == 0xAD || c == 0x2007 || c == 0x202F || c == 0xFEFF ||
           is_from_to(0x200B, 0x200F) || is_from_to(0x202A, 0x202E) || is_from_to(0x2060, 0x206F) ||
           is_from_to(0xFE00, 0xFE0F);
}

std::vector<SeenLetter> seen_letters(std::string_view text) {
    // That of the C library, which is always there, whatever the user's is.
    static const locale_t unicode = newlocale(LC_CTYPE_MASK, "C.UTF-8", nullptr);
    const locale_t before = uselocale(unicode);
    const std::string ends_in_zero(text);
    std::wstring characters(text.size(), L'\0');
    const char *from = ends_in_zero.c_str();
    std::mbstate_t state{};
    const std::size_t count = std::mbsrtowcs(characters.data(), &from, characters.size(), &state);
    std::vector<SeenLetter> letters;
    for (const wchar_t c : characters.substr(0, std::min(count, characters.size()))) {
        if (is_unseen(c) || std::iswspace(static_cast<std::wint_t>(c)) != 0) {
            continue;
        }
        if (wcwidth(c) == 0 && !letters.empty()) {
            letters.back().marks += c;
            std::ranges::sort(letters.back().marks);
        } else {
            const std::wint_t upper = std::towupper(static_cast<std::wint_t>(c));
            letters.push_back({static_cast<wchar_t>(std::towlower(upper)), c < 0x80});
        }
    }
    uselocale(before);
    return letters;
}

} // namespace

bool look_alike(std::string_view a, std::string_view b) {
    return std::ranges::equal(seen_letters(a), seen_letters(b), is_like);
}

std::string csv_for_persons(std::string csv) {
    const bool is_ascii = std::ranges::all_of(csv, [](char c) { return (c & 0x80) == 0; });
    return is_ascii ? csv : "\xEF\xBB\xBF" + csv;
}

void write_csv_for_persons(std::ostream &out, const Table &table) {
    std::ostringstream text;
    write_csv(text, table);
    out << csv_for_persons(text.str());
}

} // namespace springdrive
