// Wall-clock times of a study: UTC, to the millisecond, as ISO 8601 in files.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <string_view>

namespace springdrive::study {

using UtcTime = std::chrono::sys_time<std::chrono::milliseconds>;

/// By the system's clock.
[[nodiscard]] UtcTime utc_now();

/// "2024-05-31T12:34:56.789Z".
/// @pre the year has four digits
[[nodiscard]] std::string utc_text(UtcTime time);

/// What `utc_text` writes; nothing for any other text.
[[nodiscard]] std::optional<UtcTime> utc_time_of(std::string_view text);

} // namespace springdrive::study
