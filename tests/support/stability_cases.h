// Stability cases that several tests share.
#pragma once

#include "engine/lab/loops/stability_case.h"
#include "engine/lab/loops/stability_parameters.h"
#include "tests/support/devices.h"

#include <string_view>

namespace springdrive::testing {

/// One motor of the PHANTOM 1.0 with the tuning "firm".
inline loops::StabilityCase firm() {
    loops::StabilityCase which;
    which.device = phantom_1_0();
    return which;
}

inline const loops::StabilityParameter &named(std::string_view name) {
    return *loops::stability_parameter_named(name);
}

inline loops::StabilityCase with(loops::StabilityCase which,
                                 const loops::StabilityParameter &parameter, double value) {
    parameter.set(which, value);
    return which;
}

} // namespace springdrive::testing
