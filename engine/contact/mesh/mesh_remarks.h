// What mesh preparation found, in words for the user.
#pragma once

#include "engine/contact/mesh/mesh_preparation.h"

#include <string>
#include <vector>

namespace springdrive::contact {

/// One line for each thing about a surface that is not as a closed, clean mesh would have it, with
/// the names of the nodes it concerns; empty for a clean one.
[[nodiscard]] std::vector<std::string> remarks_on(const MeshReport &report,
                                                  const std::vector<SurfaceMaterial> &materials);

} // namespace springdrive::contact
