// The volumes that the components of a mesh enclose.
#pragma once

#include "base/vector.h"
#include "engine/contact/mesh/mesh_topology.h"
#include "engine/contact/mesh/mesh_triangle.h"

#include <vector>

namespace springdrive::contact {

/// The volume of each closed component [m³], negative where its triangles face it; zero for open
/// ones and for sheets. For a solid with sheets in it, that of the solid alone.
[[nodiscard]] std::vector<double> enclosed_volumes_m3(const std::vector<MeshTriangle> &triangles,
                                                      const MeshTopology &topology,
                                                      const std::vector<Vector3> &vertices_m);

} // namespace springdrive::contact
