// A stability map as a picture and as numbers.
#pragma once

#include "base/new_file.h"
#include "engine/lab/limits/stability_map.h"

#include <filesystem>
#include <string>
#include <vector>

namespace springdrive::app {

/// The settings of a map, for the lines below its title.
struct MapSetting {
    std::string values; ///< the device, and fixed parameters
    std::string loop;   ///< its drive and hands
};

/// "map.csv" for "map.svg".
[[nodiscard]] std::filesystem::path numbers_of_map(std::filesystem::path svg);

/// Writes `svg`, and the numbers beside it with the ending .csv, these first.
/// @throw InputError for what cannot be written or drawn.
void draw_stability_map(const std::filesystem::path &svg, const MapSetting &setting,
                        const limits::MapAxis &x, const limits::MapAxis &y,
                        const std::vector<limits::MapCell> &cells, Existing existing);

} // namespace springdrive::app
