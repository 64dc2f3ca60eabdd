// The reason why something was refused, as a value.
#pragma once

#include "base/input_error.h"

#include <string>

namespace springdrive {

/// The message of the InputError that `step` throws; empty if it throws none. Other exceptions
/// pass.
template <typename Step> [[nodiscard]] std::string error_text_of(Step &&step) {
    try {
        step();
    } catch (const InputError &error) {
        return error.what();
    }
    return {};
}

} // namespace springdrive
