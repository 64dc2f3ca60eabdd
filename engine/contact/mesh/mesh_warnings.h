// The results of mesh preparation as text for the user.
#pragma once

#include "engine/contact/mesh/mesh_report.h"
#include "engine/contact/mesh/surface_material.h"

#include <string>
#include <vector>

namespace springdrive::contact {

/// One line for each way in which a surface differs from a closed, clean mesh, with the names of
/// the nodes it concerns; empty for a clean one.
[[nodiscard]] std::vector<std::string>
warnings_about(const MeshReport &report, const std::vector<SurfaceMaterial> &materials);

} // namespace springdrive::contact
