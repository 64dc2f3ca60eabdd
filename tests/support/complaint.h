#pragma once

#include "base/complaint.h"

namespace springdrive::testing {

using springdrive::complaint_of;

} // namespace springdrive::testing
