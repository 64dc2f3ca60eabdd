#include "engine/scene/texture_scaling.h"

#include "base/assertions.h"

#include <algorithm>
#include <cstddef>

namespace springdrive::scene {

namespace {

/// The pixels of a row or column, from `first` up to `end`, that one pixel of the result covers.
struct Covered {
    std::size_t first;
    std::size_t end;
};

Covered covered_by(std::size_t pixel, std::size_t from_count, std::size_t to_count) {
    return {pixel * from_count / to_count, ((pixel + 1) * from_count + to_count - 1) / to_count};
}

} // namespace

Texture scaled_down(const Texture &texture, int max_side) {
    SPRINGDRIVE_ASSERT(max_side > 0);
    if (texture.width <= max_side && texture.height <= max_side) {
        return texture;
    }
    Texture result;
    result.width = std::min(texture.width, max_side);
    result.height = std::min(texture.height, max_side);
    result.wrap_s = texture.wrap_s;
    result.wrap_t = texture.wrap_t;
    result.holds_numbers = texture.holds_numbers;
    result.has_alpha = texture.has_alpha;
    const auto from_width = static_cast<std::size_t>(texture.width);
    const auto from_height = static_cast<std::size_t>(texture.height);
    const auto width = static_cast<std::size_t>(result.width);
    const auto height = static_cast<std::size_t>(result.height);
    result.rgba.reserve(4 * width * height);
    for (std::size_t y = 0; y < height; ++y) {
        const Covered rows = covered_by(y, from_height, height);
        for (std::size_t x = 0; x < width; ++x) {
            const Covered columns = covered_by(x, from_width, width);
            const std::size_t count =
                std::max<std::size_t>(1, (rows.end - rows.first) * (columns.end - columns.first));
            for (std::size_t channel = 0; channel < 4; ++channel) {
                std::size_t sum = count / 2; // rounds to the nearest
                for (std::size_t row = rows.first; row < rows.end; ++row) {
                    for (std::size_t column = columns.first; column < columns.end; ++column) {
                        sum += texture.rgba[4 * (row * from_width + column) + channel];
                    }
                }
                result.rgba.push_back(static_cast<std::uint8_t>(sum / count));
            }
        }
    }
    return result;
}

} // namespace springdrive::scene
