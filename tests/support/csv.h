// Reads CSV in tests: an independent reader of what the program writes.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <string>
#include <vector>

namespace springdrive::testing {

/// The cells of each line (RFC 4180).
inline std::vector<std::vector<std::string>> parsed_csv(const std::string &text) {
    std::vector<std::vector<std::string>> lines(1, {""});
    bool is_quoted = false;
    for (std::size_t i = 0; i < text.size(); ++i) {
        std::string &cell = lines.back().back();
        if (text[i] == '"' && is_quoted && i + 1 < text.size() && text[i + 1] == '"') {
            cell += text[++i];
        } else if (text[i] == '"') {
            is_quoted = !is_quoted;
        } else if (text[i] == ',' && !is_quoted) {
            lines.back().emplace_back();
        } else if (text[i] == '\n' && !is_quoted) {
            lines.push_back({""});
        } else {
            cell += text[i];
        }
    }
    lines.pop_back();
    return lines;
}

/// The rows below the header, as numbers; NaN for a cell that is empty or none.
inline std::vector<std::vector<double>> parsed_numbers(const std::string &text) {
    std::vector<std::vector<double>> rows;
    for (const std::vector<std::string> &line : parsed_csv(text)) {
        std::vector<double> &row = rows.emplace_back();
        for (const std::string &cell : line) {
            char *end = nullptr;
            const double number = std::strtod(cell.c_str(), &end);
            row.push_back(end == cell.c_str() ? NAN : number);
        }
    }
    rows.erase(rows.begin());
    return rows;
}

} // namespace springdrive::testing
