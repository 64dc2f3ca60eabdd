#include "base/field.h"

#include <fmt/core.h>

namespace springdrive {

// Written so that a NaN lies in no range.
std::string unless_from_to(std::string_view name, double value, double minimum, double maximum) {
    return value >= minimum && value <= maximum
               ? std::string()
               : fmt::format("{} is {:g}; it must be from {:g} to {:g}", name, value, minimum,
                             maximum);
}

} // namespace springdrive
