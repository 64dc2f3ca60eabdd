// Geometry on the graphics card: meshes and lines that are uploaded once, solids of the unit
// shapes, and flat shapes, all of them at once.
#pragma once

#include "app/view/gl_objects.h"
#include "app/view/marks.h"
#include "app/view/solids.h"
#include "engine/scene/scene.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace springdrive::app {

class GpuMesh {
public:
    /// @param tangents  one a vertex, or none
    GpuMesh(std::span<const scene::VisualVertex> vertices, std::span<const std::uint32_t> indices,
            std::span<const std::array<float, 4>> tangents = {});

    void draw() const; ///< with the program in use

private:
    VertexArray array_;
    Buffer vertices_;
    Buffer indices_;
    Buffer tangents_;
    GLsizei index_count_;
};

class GpuLines {
public:
    explicit GpuLines(std::span<const scene::LineSegment> lines);

    void draw() const; ///< with the program in use

private:
    VertexArray array_;
    Buffer vertices_;
    GLsizei vertex_count_;
};

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

class FlatPainter {
public:
    FlatPainter();

    /// Replaces what is drawn.
    void set(std::span<const FlatVertex> vertices);

    /// With blending. @param opacity multiplies each vertex's own
    void draw(const glm::mat4 &view_projection, float opacity) const;

    [[nodiscard]] int triangles() const { return count_ / 3; }
    /// Number of draw calls that `draw` makes.
    [[nodiscard]] int calls() const { return count_ > 0 ? 1 : 0; }

private:
    Program program_;
    VertexArray array_;
    Buffer vertices_;
    GLsizei count_ = 0;
};

} // namespace springdrive::app
