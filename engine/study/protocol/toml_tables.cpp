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
    const std::size_t end = complaint.find_first_of(" .");
    if (complaint.empty() || end == std::string::npos) {
        return;
    }
    const std::string key = complaint.substr(0, end);
    const std::string rest = complaint.substr(end + 1);
    if (complaint[end] == '.' && table.has(key)) {
        StrictTomlTable inner = table.table(key);
        refuse_as(inner, rest);
    }
    table.refuse(complaint[end] == '.' ? complaint.substr(0, complaint.find(' ')) : key,
                 complaint[end] == '.' ? complaint.substr(complaint.find(' ') + 1) : rest);
}

} // namespace springdrive::study
