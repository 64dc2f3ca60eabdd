// The report of `springdrive tune`.
#pragma once

#include <iosfwd>

namespace springdrive::limits {
struct AutoTuned;
}

namespace springdrive::app {

/// The result, its margins, and warnings on them, one line each.
void write_tuned(std::ostream &out, const limits::AutoTuned &found);

} // namespace springdrive::app
