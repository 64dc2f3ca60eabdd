// A rectangle of a picture.
#pragma once

namespace springdrive::app::study_screen {

/// In whole pixels, from the top left.
struct PixelBox {
    int x = 0;
    int y = 0;
    int width = 0;
    int height = 0;

    [[nodiscard]] bool is_empty() const { return width <= 0 || height <= 0; }
    [[nodiscard]] bool contains(double at_x, double at_y) const {
        return at_x >= x && at_y >= y && at_x < x + width && at_y < y + height;
    }
    [[nodiscard]] PixelBox moved(int right, int down) const {
        return {x + right, y + down, width, height};
    }
    /// One of that size in its middle.
    [[nodiscard]] PixelBox middle(int wide, int high) const {
        return {x + (width - wide) / 2, y + (height - high) / 2, wide, high};
    }
    friend bool operator==(const PixelBox &, const PixelBox &) = default;
};

} // namespace springdrive::app::study_screen
