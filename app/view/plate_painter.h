// Draws rectangles with round corners.
#pragma once

#include "app/view/gl_objects.h"

#include <glm/vec2.hpp>
#include <glm/vec4.hpp>

#include <span>
#include <vector>

namespace springdrive::app {

struct Plate {
    glm::vec2 corner_px; ///< top left, from the top left of the viewport
    glm::vec2 size_px;
    glm::vec4 colour;       ///< sRGB, straight alpha
    float radius_px = 0.0F; ///< of the corners
    float border_px = 0.0F; ///< width of the rim alone that is drawn; 0: all of it
};

class PlatePainter {
public:
    PlatePainter();

    /// One over the other, with blending.
    void draw(std::span<const Plate> plates, const glm::vec2 &viewport_px);

private:
    struct Vertex {
        glm::vec2 place_px;
        glm::vec2 from_centre_px;
        glm::vec2 half_px; ///< of the plate
        glm::vec2 rim_px;  ///< radius and border
        glm::vec4 colour;
    };

    Program program_;
    VertexArray array_;
    Buffer vertices_;
    std::vector<Vertex> quads_; ///< six a plate
};

} // namespace springdrive::app
