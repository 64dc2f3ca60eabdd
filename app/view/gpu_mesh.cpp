#include "app/view/gpu_mesh.h"

#include <cstddef>

namespace springdrive::app {

namespace {

/// The locations are those of shaders/lit.vert; creases.vert has the first.
void describe_attribute(GLuint location, GLint components, std::size_t offset,
                        std::size_t stride = sizeof(scene::VisualVertex)) {
    glEnableVertexAttribArray(location);
    // NOLINTBEGIN(performance-no-int-to-ptr): OpenGL takes the offset into the buffer as a pointer
    glVertexAttribPointer(location, components, GL_FLOAT, GL_FALSE, static_cast<GLsizei>(stride),
                          reinterpret_cast<const void *>(offset));
    // NOLINTEND(performance-no-int-to-ptr)
}

} // namespace

GpuMesh::GpuMesh(std::span<const scene::VisualVertex> vertices,
                 std::span<const std::uint32_t> indices,
                 std::span<const std::array<float, 4>> tangents)
    : index_count_(static_cast<GLsizei>(indices.size())) {
    glBindVertexArray(array_.name());
    glBindBuffer(GL_ARRAY_BUFFER, vertices_.name());
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertices.size_bytes()), vertices.data(),
                 GL_STATIC_DRAW);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices_.name());
    glBufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(indices.size_bytes()),
                 indices.data(), GL_STATIC_DRAW);
    describe_attribute(0, 3, offsetof(scene::VisualVertex, position_m));
    describe_attribute(1, 3, offsetof(scene::VisualVertex, normal));
    describe_attribute(2, 4, offsetof(scene::VisualVertex, colour));
    describe_attribute(3, 2, offsetof(scene::VisualVertex, texture_coordinate));
    if (!tangents.empty()) {
        glBindBuffer(GL_ARRAY_BUFFER, tangents_.name());
        glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(tangents.size_bytes()),
                     tangents.data(), GL_STATIC_DRAW);
        describe_attribute(4, 4, 0, sizeof(std::array<float, 4>));
    }
    glBindVertexArray(0);
}

void GpuMesh::draw() const {
    glBindVertexArray(array_.name());
    draw_elements(GL_TRIANGLES, index_count_);
}

GpuLines::GpuLines(std::span<const scene::LineSegment> lines)
    : vertex_count_(static_cast<GLsizei>(2 * lines.size())) {
    glBindVertexArray(array_.name());
    glBindBuffer(GL_ARRAY_BUFFER, vertices_.name());
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(lines.size_bytes()), lines.data(),
                 GL_STATIC_DRAW);
    describe_attribute(0, 3, 0, sizeof(scene::LineSegment) / 2);
    glBindVertexArray(0);
}

void GpuLines::draw() const {
    glBindVertexArray(array_.name());
    draw_arrays(GL_LINES, vertex_count_);
}

} // namespace springdrive::app
