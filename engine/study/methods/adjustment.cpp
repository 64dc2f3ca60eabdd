#include "engine/study/methods/adjustment.h"

#include "engine/study/methods/wrong_value.h"

#include <cstdint>

namespace springdrive::study {

std::string validate(const Adjustment &method) {
    return first_of({unless_level("minimum_level", method.minimum_level, method.scale),
                     unless_above("maximum_level", method.maximum_level, method.minimum_level),
                     unless_from_to("minimum_start", method.minimum_start, method.minimum_level,
                                    method.maximum_level),
                     unless_from_to("maximum_start", method.maximum_start, method.minimum_start,
                                    method.maximum_level),
                     out_of_range(kAdjustmentFields, method)});
}

std::optional<MethodTrial> AdjustmentRun::next() const {
    if (is_done()) {
        return std::nullopt;
    }
    const double first = on_scale(method_.scale, method_.minimum_start);
    const double last = on_scale(method_.scale, method_.maximum_start);
    const double share = uniform(child(key_, static_cast<std::uint64_t>(settings_)));
    return MethodTrial{level_from(method_.scale, first + share * (last - first)), 0};
}

} // namespace springdrive::study
