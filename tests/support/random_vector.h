// A random vector, for tests.
#pragma once

#include "base/vector.h"

#include <random>

namespace springdrive::testing {

/// Every coordinate uniform between −`largest` and `largest`.
inline Vector3 random_vector(std::mt19937_64 &random, double largest) {
    std::uniform_real_distribution<double> one(-largest, largest);
    const double x = one(random);
    const double y = one(random);
    return {x, y, one(random)};
}

} // namespace springdrive::testing
