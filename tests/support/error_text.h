#pragma once

#include "base/error_text.h"

namespace springdrive::testing {

using springdrive::error_text_of;

} // namespace springdrive::testing
