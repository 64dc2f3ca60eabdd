// Triangles that lie nearly on top of each other: the most work for preparation.
#pragma once

#include "tests/engine/contact/mesh/soups.h"

#include <random>

namespace springdrive::testing {

/// Triangles with corners anywhere in a box about the origin.
inline contact::TriangleSoup scattered_soup(std::mt19937_64 &random, int triangles,
                                            const Vector3 &half_m) {
    contact::TriangleSoup soup;
    for (int i = 0; i < triangles; ++i) {
        Corners triangle;
        for (Vector3 &corner : triangle) {
            corner = random_vector(random, 1.0).cwiseProduct(half_m);
        }
        add_triangle(soup, triangle);
    }
    return soup;
}

/// Triangles 10 cm long, in a line a few micrometres thick.
inline contact::TriangleSoup soup_in_a_line(std::mt19937_64 &random, int triangles) {
    return scattered_soup(random, triangles, {0.05, 3e-6, 3e-6});
}

} // namespace springdrive::testing
