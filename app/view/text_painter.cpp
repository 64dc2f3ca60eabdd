#include "app/view/text_painter.h"

#include "app/view/embedded_shaders.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>

namespace springdrive::app {

namespace {

constexpr int kFirstAtlas_px = 1024;
constexpr int kGap_px = 1; // between letters

} // namespace

TextPainter::TextPainter(const Typeface &typeface)
    : typeface_(typeface), program_("text", shaders::text_vert, shaders::text_frag) {
    glBindVertexArray(array_.name());
    glBindBuffer(GL_ARRAY_BUFFER, vertices_.name());
    glEnableVertexAttribArray(0);
    glEnableVertexAttribArray(1);
    // NOLINTBEGIN(performance-no-int-to-ptr): OpenGL takes the offset into the buffer as a pointer
    glVertexAttribPointer(0, 2, GL_FLOAT, GL_FALSE, sizeof(Vertex),
                          reinterpret_cast<const void *>(offsetof(Vertex, place_px)));
    glVertexAttribPointer(1, 2, GL_FLOAT, GL_FALSE, sizeof(Vertex),
                          reinterpret_cast<const void *>(offsetof(Vertex, texel)));
    // NOLINTEND(performance-no-int-to-ptr)
    glBindVertexArray(0);
    clear_atlas(kFirstAtlas_px);
}

void TextPainter::clear_atlas(int size_px) {
    letters_.clear();
    row_x_ = row_y_ = row_height_ = 0;
    if (size_px != size_px_) {
        size_px_ = size_px;
        atlas_.reset(); // first, so that both are never held
        atlas_.emplace(size_px, size_px, Texture2D::Format{.internal = GL_R8, .pixels = GL_RED},
                       std::span<const std::uint8_t>{});
    }
}

std::optional<std::pair<int, int>> TextPainter::take_place(int width, int height) {
    if (row_x_ + width > size_px_) {
        row_y_ += row_height_ + kGap_px;
        row_x_ = row_height_ = 0;
    }
    if (width > size_px_ || row_y_ + height > size_px_) {
        return std::nullopt;
    }
    const std::pair<int, int> place{row_x_, row_y_};
    row_x_ += width + kGap_px;
    row_height_ = std::max(row_height_, height);
    return place;
}

const TextPainter::Placed *TextPainter::placed(int glyph, int size_px) {
    const std::pair<int, int> key{glyph, size_px};
    if (const auto found = letters_.find(key); found != letters_.end()) {
        return &found->second;
    }
    const Typeface::Picture picture = typeface_.picture(glyph, size_px);
    const auto place = take_place(picture.width, picture.height);
    if (!place) {
        return nullptr;
    }
    const auto [x, y] = *place;
    if (!picture.coverage.empty()) {
        atlas_->bind(0);
        glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
        glTexSubImage2D(GL_TEXTURE_2D, 0, x, y, picture.width, picture.height, GL_RED,
                        GL_UNSIGNED_BYTE, picture.coverage.data());
    }
    const Placed letter{x, y, picture.width, picture.height, picture.left, picture.top};
    return &letters_.emplace(key, letter).first->second;
}

bool TextPainter::hold(const TextLines &text) {
    const int size_px = static_cast<int>(std::lround(text.size_px));
    for (const TextLine &line : text.lines) {
        for (const PlacedGlyph &glyph : line.glyphs) {
            if (placed(glyph.glyph, size_px) == nullptr) {
                return false;
            }
        }
    }
    return true;
}

void TextPainter::append(const Placed &letter, int x_px, int y_px) {
    const auto corner = [&](int right, int down) {
        const auto x = static_cast<float>(right * letter.width);
        const auto y = static_cast<float>(down * letter.height);
        return Vertex{
            {static_cast<float>(x_px + letter.left) + x, static_cast<float>(y_px + letter.top) + y},
            {static_cast<float>(letter.x) + x, static_cast<float>(letter.y) + y}};
    };
    quads_.insert(quads_.end(), {corner(0, 0), corner(1, 0), corner(1, 1), //
                                 corner(0, 0), corner(1, 1), corner(0, 1)});
}

void TextPainter::draw(const TextLines &text, int x_px, int y_px, const glm::vec4 &colour,
                       const glm::vec2 &viewport_px) {
    // A full texture is begun anew with what is drawn now, and is enlarged where that is too much.
    if (!hold(text)) {
        GLint most_px = 0;
        glGetIntegerv(GL_MAX_TEXTURE_SIZE, &most_px);
        clear_atlas(size_px_);
        while (!hold(text)) {
            if (2 * size_px_ > most_px) {
                throw std::runtime_error("OpenGL has no texture that holds the letters of a text");
            }
            clear_atlas(2 * size_px_);
        }
    }
    quads_.clear();
    const int size_px = static_cast<int>(std::lround(text.size_px));
    int base_px = y_px + text.ascent_px;
    for (const TextLine &line : text.lines) {
        for (const PlacedGlyph &glyph : line.glyphs) {
            append(letters_.at({glyph.glyph, size_px}), x_px + line.x_px + glyph.x_px, base_px);
        }
        base_px += text.line_height_px + (line.ends_paragraph ? text.paragraph_gap_px : 0);
    }
    if (quads_.empty()) {
        return;
    }
    glBindBuffer(GL_ARRAY_BUFFER, vertices_.name());
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(quads_.size() * sizeof(Vertex)),
                 quads_.data(), GL_STREAM_DRAW);
    program_.use();
    program_.set("viewport_px", viewport_px);
    program_.set("colour", colour);
    program_.set("letters", 0);
    atlas_->bind(0);
    glBindVertexArray(array_.name());
    draw_arrays(GL_TRIANGLES, static_cast<GLsizei>(quads_.size()));
    glBindVertexArray(0);
}

} // namespace springdrive::app
