#include "engine/contact/mesh_remarks.h"

#include <cstddef>

namespace springdrive {

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

} // namespace

std::vector<std::string> remarks_on(const MeshReport &report,
                                    const std::vector<SurfaceMaterial> &materials) {
    std::vector<std::string> remarks;
    if (report.triangles_kept < report.triangles_given) {
        remarks.push_back(names_of(report.left_out_of_material, materials) + ": " +
                          std::to_string(report.triangles_given - report.triangles_kept) + " of " +
                          std::to_string(report.triangles_given) +
                          " triangles cannot be touched, being too thin or there twice");
    }
    if (report.closed_components < report.components) {
        remarks.push_back(std::to_string(report.components - report.closed_components) + " of " +
                          std::to_string(report.components) +
                          " surfaces are open: touched from both sides");
    }
    if (report.non_manifold_edges > 0) {
        remarks.push_back(std::to_string(report.non_manifold_edges) +
                          " edges join more than two triangles: touched as they stand");
    }
    if (report.inward_components > 0) {
        remarks.push_back(std::to_string(report.inward_components) +
                          " closed surfaces face inwards: touched from within only");
    }
    return remarks;
}

} // namespace springdrive
