#include "app/view/solid_painter.h"

#include <glm/gtc/matrix_inverse.hpp>

namespace springdrive::app {

namespace {

constexpr std::array<std::uint8_t, 4> kWhite{255, 255, 255, 255};

} // namespace

SolidPainter::SolidPainter() : white_(1, 1, {}, kWhite) {
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

} // namespace springdrive::app
