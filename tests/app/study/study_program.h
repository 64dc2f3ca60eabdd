// The study commands as a user types them, and protocols that take seconds instead of an hour.
#pragma once

#include "tests/support/devices.h"
#include "tests/support/program.h"

#include <filesystem>
#include <fstream>
#include <regex>
#include <string>
#include <utility>
#include <vector>

namespace springdrive::testing {

inline Ending study(std::vector<std::string> options, int signal = 0,
                    const std::filesystem::path &started = {}) {
    options.insert(options.begin(), "study");
    return run_program(options, signal, started);
}

/// A shipped protocol with the fewest trials that its method can be told to take.
inline std::string shortened(const std::string &name) {
    std::string text = contents_of(assets() / "protocols" / (name + ".toml"));
    const std::vector<std::pair<const char *, const char *>> shorter{
        {"\nfewest_trials = \\d+", "\nfewest_trials = 2"},
        {"\nmost_trials = \\d+", "\nmost_trials = 3"},
        {"\ncorrect_in_a_row = \\d+", "\ncorrect_in_a_row = 1"},
        {"\nblocks = \\d+", "\nblocks = 1"},
    };
    for (const auto &[long_key, short_key] : shorter) {
        text = std::regex_replace(text, std::regex(long_key), short_key);
    }
    return text;
}

/// A shipped protocol in `folder` that does not say what is expected.
inline std::filesystem::path without_expected(const std::string &name,
                                              const std::filesystem::path &folder) {
    const std::filesystem::path file = folder / (name + "_without_expected.toml");
    std::ofstream(file) << std::regex_replace(shortened(name),
                                              std::regex(R"(\n\[expected\][^\[]*)"), "\n");
    return file;
}

/// Rows of a CSV file without its header.
inline std::vector<std::string> rows_of(const std::string &csv) {
    std::vector<std::string> rows;
    std::size_t begin = csv.find('\n') + 1;
    for (std::size_t end = csv.find('\n', begin); end != std::string::npos;
         end = csv.find('\n', begin)) {
        rows.push_back(csv.substr(begin, end - begin));
        begin = end + 1;
    }
    return rows;
}

/// A column of a CSV file, by its name; no cell may have a comma.
inline std::vector<std::string> column_of(const std::string &csv, const std::string &name) {
    const auto cells = [](const std::string &line) {
        std::vector<std::string> all(1);
        for (const char c : line) {
            if (c == ',') {
                all.emplace_back();
            } else {
                all.back() += c;
            }
        }
        return all;
    };
    const std::vector<std::string> names = cells(csv.substr(0, csv.find('\n')));
    std::vector<std::string> column;
    for (std::size_t i = 0; i < names.size(); ++i) {
        if (names[i] == name) {
            for (const std::string &row : rows_of(csv)) {
                column.push_back(cells(row).at(i));
            }
        }
    }
    return column;
}

} // namespace springdrive::testing
