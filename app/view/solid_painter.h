// Draws solids with the unit shapes, each of which is uploaded once.
#pragma once

#include "app/view/gpu_mesh.h"
#include "app/view/solids.h"

#include <span>
#include <vector>

namespace springdrive::app {

class SolidPainter {
public:
    SolidPainter();

    /// With shaders/lit.* active. @param opacity multiplies each solid's own
    void draw(const Program &lit, std::span<const Solid> solids, float opacity = 1.0F) const;

    /// With an active program whose only uniform to set is `model`.
    void draw_geometry(const Program &program, std::span<const Solid> solids) const;

private:
    [[nodiscard]] const GpuMesh &mesh(Shape shape) const {
        return meshes_[static_cast<std::size_t>(shape)];
    }

    std::vector<GpuMesh> meshes_; ///< in the order of kShapes
    Texture2D white_;
};

} // namespace springdrive::app
