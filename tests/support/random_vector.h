// Random vectors, for tests.
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

inline Vector3 random_direction(std::mt19937_64 &random) {
    std::normal_distribution<double> coordinate;
    const double x = coordinate(random);
    const double y = coordinate(random);
    const double z = coordinate(random);
    return Vector3(x, y, z).normalized();
}

} // namespace springdrive::testing
