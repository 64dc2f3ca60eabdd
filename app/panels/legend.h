// What is drawn in the scene, by name and colour, each with its switch.
#pragma once

#include "app/view/shown_things.h"
#include "app/view/touch_values.h"
#include "app/widgets/rectangle.h"

namespace springdrive::app {

/// At the right edge of the scene: a button, or, once it is open, a plate with a row for each
/// thing.
/// @param top     of the button or plate
/// @param width   of the button
/// @param values  that are drawn now, whose ranges stand in the rows
/// @return the plate's width, 0 for a button
float draw_legend(ShownThings &shown, bool &is_open, const TouchValues &values,
                  const Rectangle &view, float top, float width, float scale);

} // namespace springdrive::app
