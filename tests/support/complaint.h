#pragma once

#include "base/input_error.h"

#include <string>

namespace springdrive::testing {

/// What InputError says; empty when nothing was thrown.
template <typename Step> std::string complaint_of(Step &&step) {
    try {
        step();
    } catch (const InputError &error) {
        return error.what();
    }
    return "";
}

} // namespace springdrive::testing
