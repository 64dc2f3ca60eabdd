// The touchable side of a scene: triangles in metres, device frame, prepared and searchable.
#pragma once

#include "base/vector.h"
#include "engine/contact/preparation/mesh_preparation.h"
#include "engine/contact/triangle_soup.h"
#include "engine/contact/triangle_tree.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace springdrive {

/// Immutable: any number of threads may ask it at once. An empty mesh can never be touched.
///
/// Surfaces that bound a volume stop the tip from outside only, so that a tip that starts within
/// may leave. All others stop it from both sides.
class HapticSurface {
public:
    HapticSurface() = default;

    /// @throw std::invalid_argument as `prepare_mesh` does
    explicit HapticSurface(TriangleSoup soup);

    /// The first facet that stops a straight motion, if any does. RT-safe.
    [[nodiscard]] std::optional<SurfaceHit> first_hit(const Vector3 &from_m,
                                                      const Vector3 &to_m) const noexcept {
        return tree_.first_hit(from_m, to_m);
    }

    /// η of a triangle of the soup. @pre the index is one of a facet of this mesh. RT-safe.
    [[nodiscard]] double eta(std::uint32_t triangle) const noexcept {
        return materials_[material_of_triangle_[triangle]].eta;
    }

    [[nodiscard]] const MeshReport &report() const noexcept { return report_; }

private:
    std::vector<SurfaceMaterial> materials_;
    std::vector<std::uint16_t> material_of_triangle_;
    MeshReport report_;
    TriangleTree tree_;
};

} // namespace springdrive
