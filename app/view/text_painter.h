// Draws text with OpenGL. Letters are rasterised when a text first needs them.
#pragma once

#include "app/view/gl_objects.h"
#include "app/view/text_lines.h"

#include <glm/vec2.hpp>
#include <glm/vec4.hpp>

#include <map>
#include <optional>
#include <utility>
#include <vector>

namespace springdrive::app {

/// Needs a current OpenGL context, always the same.
class TextPainter {
public:
    /// @param typeface  must outlive this
    explicit TextPainter(const Typeface &typeface);

    /// Draws lines with their top left corner at whole pixels of the viewport, from its top left,
    /// with blending. @param colour sRGB, straight alpha
    void draw(const TextLines &text, int x_px, int y_px, const glm::vec4 &colour,
              const glm::vec2 &viewport_px);

    /// Width and height of the texture that holds the letters.
    [[nodiscard]] int atlas_px() const { return size_px_; }

private:
    /// A letter in the texture.
    struct Placed {
        int x = 0;
        int y = 0;
        int width = 0;
        int height = 0;
        int left = 0; ///< as in Typeface::Picture
        int top = 0;
    };
    struct Vertex {
        glm::vec2 place_px;
        glm::vec2 texel;
    };

    /// The letter, rasterised if it is new; null if there is no room for it.
    const Placed *placed(int glyph, int size_px);
    /// A free place of that size; nothing if there is none.
    std::optional<std::pair<int, int>> take_place(int width, int height);
    void clear_atlas(int size_px);
    /// Whether all of its letters are in the texture.
    bool hold(const TextLines &text);
    void append(const Placed &letter, int x_px, int y_px);

    const Typeface &typeface_;
    Program program_;
    VertexArray array_;
    Buffer vertices_;
    int size_px_ = 0;
    std::optional<Texture2D> atlas_;
    std::map<std::pair<int, int>, Placed> letters_; ///< by glyph and size
    // Letters are in rows from the top, each as high as its highest letter.
    int row_x_ = 0;
    int row_y_ = 0;
    int row_height_ = 0;
    std::vector<Vertex> quads_; ///< of the text being drawn, six a letter
};

} // namespace springdrive::app
