#include "base/print.h"

#include "base/formula_guard.h"

#include <cmath>
#include <ostream>

namespace springdrive {

void print_checked(std::ostream &out, fmt::string_view format, fmt::format_args values) {
    out << fmt::vformat(format, values);
}

std::string csv_cell(std::string_view text) {
    const std::string guarded = guard_formula(text);
    if (guarded.find_first_of(",\"\n\r") == std::string::npos) {
        return guarded;
    }
    std::string quoted = "\"";
    for (const char c : guarded) {
        quoted += c == '"' ? "\"\"" : std::string(1, c);
    }
    return quoted + '"';
}

std::string csv_cell(double number) {
    return std::isfinite(number) ? fmt::format("{}", number) : "";
}

} // namespace springdrive
