#include "engine/contact/mesh/mesh_report.h"

#include "engine/contact/mesh/fan_grading.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace springdrive::contact {

namespace {

constexpr std::size_t kNamesInFull = 3;

/// "node 'a', 'b', 'c' and 4 more", of the materials that have any triangle left out.
std::string names_of(const std::vector<std::size_t> &left_out,
                     const std::vector<SurfaceMaterial> &materials) {
    std::string names;
    std::size_t concerned = 0;
    for (std::size_t i = 0; i < left_out.size(); ++i) {
        if (left_out[i] > 0 && ++concerned <= kNamesInFull) {
            names += (names.empty() ? "'" : ", '") + materials[i].name + "'";
        }
    }
    const std::string more = concerned > kNamesInFull
                                 ? " and " + std::to_string(concerned - kNamesInFull) + " more"
                                 : "";
    return (concerned > 1 ? "nodes " : "node ") + names + more;
}

/// "3 triangles are", "1 triangle is".
std::string counted(std::size_t count, const std::string &thing, const std::string &verb_of_one,
                    const std::string &verb_of_more) {
    return std::to_string(count) + " " + thing +
           (count == 1 ? " " + verb_of_one : "s " + verb_of_more);
}

/// In micrometres, rounded up to a tenth.
std::string micrometres(double length_m) {
    const auto tenths = static_cast<long>(std::ceil(1e7 * length_m));
    return std::to_string(tenths / 10) + "." + std::to_string(tenths % 10) + " µm";
}

std::string on_closing(const MeshReport &report) {
    const std::string open = report.open_edges == 0
                                 ? "none is open now"
                                 : std::to_string(report.open_edges) + " are open now";
    return counted(report.open_edges_given, "edge", "was", "were") + " open: closed by moving " +
           std::to_string(report.closed_cracks) + " vertices and dividing " +
           std::to_string(report.split_triangles) + " triangles, with moves of up to " +
           micrometres(report.largest_move_m) + "; " + open;
}

} // namespace

std::vector<std::string> warnings_about(const MeshReport &report,
                                        const std::vector<SurfaceMaterial> &materials) {
    const bool is_automatic = std::ranges::all_of(materials, [](const SurfaceMaterial &material) {
        return material.sides == TouchSides::automatic;
    });
    const std::string unless = is_automatic ? "" : ", unless their nodes specify otherwise";
    std::vector<std::string> warnings;
    const std::size_t left_out = report.degenerate_triangles + report.duplicate_triangles;
    if (left_out > 0) {
        warnings.push_back(names_of(report.left_out_of_material, materials) + ": " +
                           std::to_string(left_out) + " of " +
                           std::to_string(report.triangles_given) +
                           " triangles cannot be touched: too thin, or duplicates of others");
    }
    if (report.closed_cracks + report.split_triangles > 0) {
        warnings.push_back(on_closing(report));
    }
    if (report.graded_fans.coarse > 0) {
        warnings.push_back(counted(report.graded_fans.coarse, "fan", "has", "have") +
                           " many triangles at one vertex: divided anew, within " +
                           micrometres(kCoarseGradingError_m));
    }
    if (report.merged_triangles > 0) {
        warnings.push_back(counted(report.merged_triangles, "triangle", "is", "are") +
                           " given in both windings: touched from both sides");
    }
    if (report.flipped_triangles > 0) {
        warnings.push_back(counted(report.flipped_triangles, "triangle", "was", "were") +
                           " wound opposite to neighbours: turned");
    }
    if (report.unorientable_components > 0) {
        warnings.push_back(counted(report.unorientable_components, "surface", "has", "have") +
                           " no outside, like a Möbius strip: touched from both sides");
    }
    if (report.closed_components < report.components) {
        warnings.push_back(std::to_string(report.components - report.closed_components) + " of " +
                           std::to_string(report.components) +
                           " surfaces are open: touched from both sides" + unless);
    }
    if (report.non_manifold_edges > 0) {
        warnings.push_back(std::to_string(report.non_manifold_edges) +
                           " edges join more than two triangles: left unchanged");
    }
    if (report.inward_components > 0) {
        warnings.push_back(std::to_string(report.inward_components) +
                           " closed surfaces face inwards: touched from within only" + unless);
    }
    return warnings;
}

} // namespace springdrive::contact
