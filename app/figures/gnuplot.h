// Charts drawn by the gnuplot program.
#pragma once

#include <filesystem>
#include <string>

namespace springdrive::app {

/// A chart for gnuplot to draw.
struct Chart {
    std::filesystem::path script; ///< run after the style.gnuplot beside it, which opens `svg`
    std::string assignments;      ///< in gnuplot's language, before the script
    std::filesystem::path folder; ///< where `csv` is and `svg` will be
    std::string csv;
    std::string svg;
};

/// Draws a chart; an existing one of that name is replaced. No shell is involved, so any folder
/// name works.
/// @throw InputError if gnuplot is missing, or if it fails or leaves an incomplete file, with its
///        last message.
void draw(const Chart &chart);

} // namespace springdrive::app
