// Finds vertices that are meant to be the same point: exporters repeat a vertex for every normal
// and texture coordinate it carries, and only positions matter to contact.
#pragma once

#include "base/vector.h"
#include "engine/contact/mesh/preparation_allowance.h"

#include <cstdint>
#include <vector>

namespace springdrive::contact {

/// For each vertex the index of its representative: itself, or an earlier vertex within
/// `tolerance_m` that represents itself. So no vertex moves by more than the tolerance, however
/// long a chain of near neighbours is. Vertices that are not finite represent themselves.
/// @pre tolerance_m > 0, threads > 0
/// @throw InputError where it needs more steps than allowed
[[nodiscard]] std::vector<std::uint32_t> weld_vertices(const std::vector<Vector3> &vertices_m,
                                                       double tolerance_m,
                                                       PreparationAllowance &allowance,
                                                       unsigned threads = 1);

} // namespace springdrive::contact
