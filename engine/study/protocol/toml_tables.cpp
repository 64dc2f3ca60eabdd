#include "engine/study/protocol/toml_tables.h"

#include <algorithm>

namespace springdrive::study {

namespace {

constexpr std::size_t kMostLevels = 1000;

} // namespace

void read_levels(StrictTomlTable &table, std::string_view key, std::vector<double> &into) {
    if (table.has_optional(key)) {
        into = table.numbers(key, {-kLargestLevel, kLargestLevel}, kMostLevels);
    }
}

void read_text(StrictTomlTable &table, std::string_view key, std::string &into) {
    if (!table.has_optional(key)) {
        return;
    }
    constexpr std::size_t kLongest = 10'000;
    into = table.text(key);
    const bool is_blank = std::ranges::all_of(into, [](char c) { return c >= 0 && c <= ' '; });
    if (is_blank || into.size() > kLongest) {
        table.refuse(key, "has " + std::to_string(into.size()) +
                              " bytes; it must be a text that can be read, of 1 to " +
                              std::to_string(kLongest));
    }
}

void refuse_as(StrictTomlTable &table, const std::string &complaint) {
    if (complaint.empty()) {
        return;
    }
    const std::size_t end = std::min(complaint.find(' '), complaint.size());
    const std::string key = complaint.substr(0, end);
    const std::size_t dot = key.find('.');
    if (dot != std::string::npos && table.has(key.substr(0, dot))) {
        StrictTomlTable inner = table.table(key.substr(0, dot));
        refuse_as(inner, complaint.substr(dot + 1));
    }
    table.refuse(key, complaint.substr(std::min(end + 1, complaint.size())));
}

} // namespace springdrive::study
