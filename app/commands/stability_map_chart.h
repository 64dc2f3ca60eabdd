// A stability map as a picture and as numbers.
#pragma once

#include "engine/analysis/stability/stability_map.h"

#include <filesystem>
#include <string>
#include <vector>

namespace springdrive {

/// A header and a row for each cell.
[[nodiscard]] std::string stability_map_csv(const MapAxis &x, const MapAxis &y,
                                            const std::vector<MapCell> &cells);

/// Writes `svg`, and the numbers beside it with the ending .csv, these first.
/// @param setting  what was held, for the line below the title
/// @throw InputError for what cannot be written or drawn.
void draw_stability_map(const std::filesystem::path &svg, const std::string &setting,
                        const MapAxis &x, const MapAxis &y, const std::vector<MapCell> &cells);

} // namespace springdrive
