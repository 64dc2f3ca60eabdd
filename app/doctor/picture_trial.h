// Whether a window with OpenGL can be opened here.
#pragma once

#include "app/doctor/trial.h"

#include <string_view>

namespace springdrive::app::doctor {

/// Opens a hidden window. For a process of its own: graphics drivers may end it.
[[nodiscard]] PictureTrial try_picture();

} // namespace springdrive::app::doctor
