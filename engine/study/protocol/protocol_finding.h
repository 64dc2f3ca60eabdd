// What a check of a protocol found.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::study {

enum class Severity : std::uint8_t {
    error,   ///< nobody should sit down before it is repaired
    warning, ///< to be judged
    note,    ///< to be known
};

struct ProtocolFinding {
    Severity severity = Severity::error;
    std::string where;  ///< "condition \"soft\" at level 0.9", "breaks"
    std::string what;   ///< with the figures that show it
    std::string remedy; ///< what to do; empty for most notes
};

using ProtocolFindings = std::vector<ProtocolFinding>;

[[nodiscard]] bool has_errors(const ProtocolFindings &findings);

/// "error: WHERE: WHAT; REMEDY", on one line.
[[nodiscard]] std::string text_of(const ProtocolFinding &finding);

} // namespace springdrive::study
