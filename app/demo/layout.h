// The layout of the window, in which no panel covers the scene.
//
//   ┌──────────────────────┬───────────┐
//   │                      │ Tuning    │
//   │        scene         ├───────────┤
//   │                      │ Servo     │
//   ├──────────────────────┼───────────┤
//   │ Plots                │ Scene     │
//   └──────────────────────┴───────────┘
//
// While the assistant is open, it has the column on the right, which is wider then. Without panels,
// the scene has the whole window. The plate of the first minute stands below the scene, so that it
// hides nothing that it speaks of.
#pragma once

#include "app/widgets/rectangle.h"

#include <algorithm>

namespace springdrive::app {

struct Layout {
    Rectangle scene_view;
    Rectangle tuning;
    Rectangle servo;
    Rectangle scene;
    Rectangle plots;
    Rectangle assistant; ///< in the place of tuning, servo and scene
    Rectangle start;     ///< the plate of the first minute; empty unless it is asked for
};

/// Of the column on the right, times the scale.
inline constexpr float kPanels = 400.0F;
inline constexpr float kAssistant = 460.0F;

/// @param size   of the window, in ImGui's units
/// @param scale         of text and panels
/// @param plots_height  of the plots' panel, as wanted
/// @param width         of the column on the right, times the scale, as wanted
[[nodiscard]] inline Layout layout(ImVec2 size, float scale, float plots_height,
                                   float width = kPanels) {
    const float column = std::min(width * scale, 0.55F * size.x);
    const float strip = std::min(plots_height, size.y - 100.0F * scale);
    const float left = size.x - column;
    const float tuning = std::min(372.0F * scale, 0.6F * size.y);
    const float servo = std::min(176.0F * scale, 0.25F * size.y);
    Layout result;
    result.scene_view = {{0.0F, 0.0F}, {left, size.y - strip}};
    result.plots = {{0.0F, size.y - strip}, {left, strip}};
    result.tuning = {{left, 0.0F}, {column, tuning}};
    result.servo = {{left, tuning}, {column, servo}};
    result.scene = {{left, tuning + servo}, {column, size.y - tuning - servo}};
    result.assistant = {{left, 0.0F}, {column, size.y}};
    return result;
}

/// Without panels: scene and read-outs only.
[[nodiscard]] inline Layout layout_of_scene(ImVec2 size) {
    Layout result;
    result.scene_view = {{0.0F, 0.0F}, size};
    return result;
}

/// The same with a plate of that height below the scene.
[[nodiscard]] inline Layout with_start_card(Layout places, float height) {
    Rectangle &view = places.scene_view;
    height = std::min(height, 0.5F * view.size.y);
    view.size.y -= height;
    places.start = {{view.corner.x, view.corner.y + view.size.y}, {view.size.x, height}};
    return places;
}

} // namespace springdrive::app
