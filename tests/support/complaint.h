#pragma once

#include "base/input_error.h"

#include <string>

namespace springdrive::testing {

/// The message of the InputError that `step` throws; empty if it throws nothing.
template <typename Step> std::string complaint_of(Step &&step) {
    try {
        step();
    } catch (const InputError &error) {
        return error.what();
    }
    return "";
}

} // namespace springdrive::testing
