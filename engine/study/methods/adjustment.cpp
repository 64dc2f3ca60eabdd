#include "engine/study/methods/adjustment.h"

#include "engine/study/methods/wrong_value.h"

#include <limits>

namespace springdrive::study {

std::string what_is_wrong_with(const Adjustment &method) {
    constexpr double kMost = std::numeric_limits<double>::max();
    return first_of({method.scale == Scale::logarithmic
                         ? unless_above("minimum_level", method.minimum_level, 0.0)
                         : unless_from_to("minimum_level", method.minimum_level, -kMost, kMost),
                     unless_above("maximum_level", method.maximum_level, method.minimum_level),
                     unless_from_to("minimum_start", method.minimum_start, method.minimum_level,
                                    method.maximum_level),
                     unless_from_to("maximum_start", method.maximum_start, method.minimum_start,
                                    method.maximum_level),
                     unless_from_to("settings", method.settings, 1, 1000)});
}

} // namespace springdrive::study
