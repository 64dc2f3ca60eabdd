#include "app/view/painters.h"

#include "app/view/embedded_shaders.h"

#include <glm/gtc/matrix_inverse.hpp>

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

constexpr std::array<std::uint8_t, 4> kWhitePixel{255, 255, 255, 255};

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

SolidPainter::SolidPainter() : white_(1, 1, {}, kWhitePixel) {
    meshes_.reserve(kShapes.size());
    for (const Shape shape : kShapes) {
        const ShapeMesh &made = unit_shape(shape);
        meshes_.emplace_back(made.vertices, made.indices);
    }
}

void SolidPainter::draw(const Program &lit, std::span<const Solid> solids, float opacity) const {
    white_.bind(0);
    for (const Solid &solid : solids) {
        lit.set("model", solid.model);
        lit.set("normal_matrix", glm::inverseTranspose(glm::mat3(solid.model)));
        lit.set("colour", solid.colour * glm::vec4(1.0F, 1.0F, 1.0F, opacity));
        mesh(solid.shape).draw();
    }
}

void SolidPainter::draw_geometry(const Program &program, std::span<const Solid> solids) const {
    for (const Solid &solid : solids) {
        program.set("model", solid.model);
        mesh(solid.shape).draw();
    }
}

FlatPainter::FlatPainter() : program_("flat", shaders::flat_vert, shaders::flat_frag) {
    glBindVertexArray(array_.name());
    glBindBuffer(GL_ARRAY_BUFFER, vertices_.name());
    glEnableVertexAttribArray(0);
    glEnableVertexAttribArray(1);
    // NOLINTBEGIN(performance-no-int-to-ptr): OpenGL takes the offset into the buffer as a pointer
    glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, sizeof(FlatVertex),
                          reinterpret_cast<const void *>(offsetof(FlatVertex, position_m)));
    glVertexAttribPointer(1, 4, GL_FLOAT, GL_FALSE, sizeof(FlatVertex),
                          reinterpret_cast<const void *>(offsetof(FlatVertex, colour)));
    // NOLINTEND(performance-no-int-to-ptr)
    glBindVertexArray(0);
}

void FlatPainter::set(std::span<const FlatVertex> vertices) {
    count_ = static_cast<GLsizei>(vertices.size());
    glBindBuffer(GL_ARRAY_BUFFER, vertices_.name());
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertices.size_bytes()), vertices.data(),
                 GL_STREAM_DRAW);
}

void FlatPainter::draw(const glm::mat4 &view_projection, float opacity) const {
    if (count_ == 0) {
        return;
    }
    program_.use();
    program_.set("view_projection", view_projection);
    program_.set("opacity", opacity);
    glBindVertexArray(array_.name());
    draw_arrays(GL_TRIANGLES, count_);
}

} // namespace springdrive::app
