// Draws flat shapes, all of them at once.
#pragma once

#include "app/view/flat_shapes.h"
#include "app/view/gl_objects.h"

#include <span>

namespace springdrive::app {

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
