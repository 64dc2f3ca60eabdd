// What is done when the X server goes away: by default Xlib ends the program at once, while the
// servo runs.
#pragma once

#include <functional>

namespace springdrive::app::exhibit {

/// The exit status of a program that lost its display.
inline constexpr int kLostDisplay = 4;

/// From now on, `last_wishes` is called when the display is lost; then the program ends with one
/// line on standard error and kLostDisplay. Does nothing with another windowing system.
/// @pre a window is open
void end_well_without_display(std::function<void()> last_wishes);

} // namespace springdrive::app::exhibit
