// What a thread needs from the system to keep a deadline, and what the system said to it.
#pragma once

#include <string>
#include <vector>

namespace springdrive {

/// Asks for real-time priority for the calling thread, for memory that is never paged out, and
/// touches its stack beforehand. Returns a remark for each thing refused, with its remedy; empty
/// when all was granted. Call once at a thread's start: allocates.
[[nodiscard]] std::vector<std::string> make_this_thread_real_time();

} // namespace springdrive
