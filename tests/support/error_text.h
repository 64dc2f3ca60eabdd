#pragma once

#include "base/input_error.h"

namespace springdrive::testing {

using springdrive::error_text_of;

} // namespace springdrive::testing
