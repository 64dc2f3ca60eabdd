#include "engine/contact/haptic_surface.h"

#include <utility>

namespace springdrive {

HapticSurface::HapticSurface(TriangleSoup soup) {
    const PreparedMesh prepared = prepare_mesh(soup);
    report_ = prepared.report;
    tree_ = TriangleTree(prepared.facets);
    materials_ = std::move(soup.materials);
    material_of_triangle_ = std::move(soup.material_of_triangle);
}

} // namespace springdrive
