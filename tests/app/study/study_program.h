// The study commands as a user types them, and protocols that take seconds instead of an hour.
#pragma once

#include "tests/support/csv.h"
#include "tests/support/devices.h"
#include "tests/support/program.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <regex>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace springdrive::testing {

inline Ending study(std::vector<std::string> options, int signal = 0,
                    const std::filesystem::path &started = {}) {
    options.insert(options.begin(), "study");
    return run_program(options, signal, started);
}

/// Patterns, and what each place of them becomes.
using Replacements = std::vector<std::pair<std::string, std::string>>;

inline std::string with(std::string text, const Replacements &replacements) {
    for (const auto &[pattern, replacement] : replacements) {
        text = std::regex_replace(text, std::regex(pattern), replacement);
    }
    return text;
}

/// A shipped protocol with the fewest trials that its method can be told to take.
inline std::string shortened(const std::string &name) {
    return with(contents_of(assets() / "protocols" / (name + ".toml")),
                {{"\nfewest_trials = \\d+", "\nfewest_trials = 2"},
                 {"\nmost_trials = \\d+", "\nmost_trials = 3"},
                 {"\ncorrect_in_a_row = \\d+", "\ncorrect_in_a_row = 1"},
                 {"\nblocks = \\d+", "\nblocks = 1"}});
}

/// A shipped protocol in `folder` that does not say what is expected.
inline std::filesystem::path without_expected(const std::string &name,
                                              const std::filesystem::path &folder) {
    const std::filesystem::path file = folder / (name + "_without_expected.toml");
    std::ofstream(file) << with(shortened(name), {{R"(\n\[expected\][^\[]*)", "\n"}});
    return file;
}

/// A column of a CSV file, by its name.
inline std::vector<std::string> column_of(const std::string &csv, const std::string &name) {
    const auto lines = parsed_csv(csv);
    const auto at = std::ranges::find(lines.front(), name) - lines.front().begin();
    std::vector<std::string> column;
    for (const auto &line : std::span(lines).subspan(1)) {
        column.push_back(line.at(static_cast<std::size_t>(at)));
    }
    return column;
}

} // namespace springdrive::testing
