// Pictures of a study, drawn by assets/figures/study_*.gnuplot from the tables beside them.
#pragma once

#include "app/figures/gnuplot.h"
#include "app/host/folders.h"
#include "engine/study/protocol/protocol.h"

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>

namespace springdrive::app {

[[nodiscard]] inline Chart study_picture(std::string_view script, const ChartMarks &marks,
                                         const std::filesystem::path &folder, std::string csv,
                                         std::string svg, std::string second_csv = {}) {
    return {asset_folder() / "figures" / script,
            marks.assignments(),
            folder,
            std::move(csv),
            std::move(svg),
            std::move(second_csv)};
}

/// "turn_deg [°]"
[[nodiscard]] inline std::string level_label(const study::Protocol &protocol) {
    const std::string unit(study::variable_of(protocol).unit);
    return study::level_name_of(protocol) + (unit == "–" ? std::string() : " [" + unit + "]");
}

} // namespace springdrive::app
