// Charts drawn by the gnuplot program.
#pragma once

#include <filesystem>
#include <string>

namespace springdrive::app {

/// A chart that gnuplot is to draw.
struct Chart {
    std::filesystem::path script; ///< run after the style.gnuplot beside it, which opens `svg`
    std::string assignments;      ///< in gnuplot's language, before the script
    std::filesystem::path folder; ///< where `csv` is and `svg` will be
    std::string csv;
    std::string svg;
};

/// Draws a chart; an earlier one of that name is replaced. No shell takes part, so that any folder
/// will do.
/// @throw InputError where gnuplot is missing, and where it fails or leaves half a file, with its
///        own last word.
void draw(const Chart &chart);

} // namespace springdrive::app
