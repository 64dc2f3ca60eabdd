#include "app/view/plate_painter.h"

#include "app/view/embedded_shaders.h"

#include <array>
#include <cstddef>

namespace springdrive::app {

PlatePainter::PlatePainter() : program_("plate", shaders::plate_vert, shaders::plate_frag) {
    glBindVertexArray(array_.name());
    glBindBuffer(GL_ARRAY_BUFFER, vertices_.name());
    struct Attribute {
        GLint size;
        std::size_t offset;
    };
    constexpr std::array<Attribute, 5> kAttributes{{{2, offsetof(Vertex, place_px)},
                                                    {2, offsetof(Vertex, from_centre_px)},
                                                    {2, offsetof(Vertex, half_px)},
                                                    {2, offsetof(Vertex, rim_px)},
                                                    {4, offsetof(Vertex, colour)}}};
    for (GLuint i = 0; i < kAttributes.size(); ++i) {
        glEnableVertexAttribArray(i);
        // NOLINTNEXTLINE(performance-no-int-to-ptr): OpenGL takes the offset as a pointer
        glVertexAttribPointer(i, kAttributes[i].size, GL_FLOAT, GL_FALSE, sizeof(Vertex),
                              reinterpret_cast<const void *>(kAttributes[i].offset));
    }
    glBindVertexArray(0);
}

void PlatePainter::draw(std::span<const Plate> plates, const glm::vec2 &viewport_px) {
    quads_.clear();
    for (const Plate &plate : plates) {
        const glm::vec2 half = 0.5F * plate.size_px;
        const glm::vec2 centre = plate.corner_px + half;
        const glm::vec2 rim{plate.radius_px, plate.border_px};
        const auto corner = [&](float right, float down) {
            const glm::vec2 from_centre = half * glm::vec2(right, down);
            return Vertex{centre + from_centre, from_centre, half, rim, plate.colour};
        };
        quads_.insert(quads_.end(), {corner(-1, -1), corner(1, -1), corner(1, 1), //
                                     corner(-1, -1), corner(1, 1), corner(-1, 1)});
    }
    if (quads_.empty()) {
        return;
    }
    glBindBuffer(GL_ARRAY_BUFFER, vertices_.name());
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(quads_.size() * sizeof(Vertex)),
                 quads_.data(), GL_STREAM_DRAW);
    program_.use();
    program_.set("viewport_px", viewport_px);
    glBindVertexArray(array_.name());
    draw_arrays(GL_TRIANGLES, static_cast<GLsizei>(quads_.size()));
    glBindVertexArray(0);
}

} // namespace springdrive::app
