// What `springdrive tune` says of a tuning that it found.
#pragma once

#include <iosfwd>

namespace springdrive::limits {
struct AutoTuned;
}

namespace springdrive::app {

/// What was found, its margins, and what is to be known about them, a line each.
void write_tuned(std::ostream &out, const limits::AutoTuned &found);

} // namespace springdrive::app
