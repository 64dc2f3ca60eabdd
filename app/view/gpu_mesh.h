// Triangles and lines on the graphics card, uploaded once.
#pragma once

#include "app/view/gl_objects.h"
#include "engine/scene/scene.h"

#include <array>
#include <cstdint>
#include <span>

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

} // namespace springdrive::app
