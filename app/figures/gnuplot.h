// Charts drawn by the gnuplot program.
#pragma once

#include "base/new_file.h"

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::app {

/// Names and values for a gnuplot script, as lines in gnuplot's own language. Texts stay as they
/// are if the script draws them as labels or titles with "noenhanced": those of tics are formats.
class ChartMarks {
public:
    void add(std::string_view name, double number);
    void add(std::string_view name, std::string_view text);
    /// To be plotted as "$NAME".
    void add(std::string_view name, const std::vector<std::vector<double>> &rows);

    [[nodiscard]] const std::string &assignments() const { return assignments_; }

private:
    std::string assignments_;
};

/// A chart for gnuplot to draw.
struct Chart {
    std::filesystem::path script; ///< run after the style.gnuplot beside it, which opens `svg`
    std::string assignments;      ///< lines in gnuplot's language, before the script
    std::filesystem::path folder; ///< where the tables are and `svg` will be
    std::string csv;              ///< a table of numbers, if any; texts in it are not read
    std::string svg;
    std::string second_csv{}; ///< another table, if any
};

/// Of tables in `folder`, drawn by one of the program's scripts.
/// @param script  its name without ".gnuplot"
[[nodiscard]] Chart chart_of(std::string_view script, const ChartMarks &marks,
                             const std::filesystem::path &folder, std::string csv, std::string svg,
                             std::string second_csv = {});

/// Draws a chart, which appears when it is complete. No shell is involved, so any folder name
/// works.
/// @throw InputError if gnuplot is missing, or if it fails or leaves an incomplete file, with its
///        last message, or if there is a chart of that name that is to be kept.
void draw(const Chart &chart, FilePolicy policy);

/// The file of a chart's numbers: "map.csv" for "map.svg".
[[nodiscard]] std::filesystem::path numbers_of(std::filesystem::path svg);

/// Draws `svg` by one of the program's scripts, from the numbers beside it.
/// @param script  its name without ".gnuplot"
/// @throw InputError as `draw` does
void draw_numbers(const std::filesystem::path &svg, std::string_view script,
                  const ChartMarks &marks, FilePolicy policy);

} // namespace springdrive::app
