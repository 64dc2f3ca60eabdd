// Names that are close to a mistyped one, for messages.
#pragma once

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <string_view>
#include <vector>

namespace springdrive {

/// Levenshtein distance: the number of letters to insert, delete or change.
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

/// Sorts names by their distance to `typed`, the nearest first; equally near ones keep their order.
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

} // namespace springdrive
