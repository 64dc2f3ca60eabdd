// A part of the window, in ImGui's units.
#pragma once

#include <imgui.h>

namespace springdrive::app {

struct Rectangle {
    ImVec2 corner; ///< top left
    ImVec2 size;

    [[nodiscard]] ImVec2 end() const { return {corner.x + size.x, corner.y + size.y}; }

    [[nodiscard]] bool contains(ImVec2 point) const {
        return point.x >= corner.x && point.y >= corner.y && point.x < end().x && point.y < end().y;
    }

    [[nodiscard]] friend bool operator==(const Rectangle &a, const Rectangle &b) {
        return a.corner.x == b.corner.x && a.corner.y == b.corner.y && a.size.x == b.size.x &&
               a.size.y == b.size.y;
    }
};

} // namespace springdrive::app
