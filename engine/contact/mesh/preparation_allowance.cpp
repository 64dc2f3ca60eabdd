#include "engine/contact/mesh/preparation_allowance.h"

#include "base/input_error.h"

#include <cmath>
#include <string>

namespace springdrive::contact {

namespace {

[[nodiscard]] std::string in_millions(double steps) {
    return std::to_string(std::llround(steps / 1e6)) + " million";
}

} // namespace

void PreparationAllowance::refuse(std::string_view purpose, double needed_steps) const {
    const auto allowed = static_cast<double>(allowed_);
    throw InputError(
        "preparing its " + std::to_string(triangles_) + " triangles for touch needs " +
        (needed_steps > allowed ? "about " + in_millions(needed_steps)
                                : "more than " + in_millions(allowed)) +
        " steps, most of them to " + std::string(purpose) + "; at most " + in_millions(allowed) +
        " are allowed: join vertices that nearly coincide, remove triangles that lie on top of "
        "each other, or enlarge it");
}

} // namespace springdrive::contact
