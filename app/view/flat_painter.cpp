#include "app/view/flat_painter.h"

#include "app/view/embedded_shaders.h"

#include <cstddef>

namespace springdrive::app {

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
