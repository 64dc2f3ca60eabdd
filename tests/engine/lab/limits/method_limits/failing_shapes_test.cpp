// Covers engine/lab/limits/method_limits/failing_shapes.cpp.
#include "engine/lab/limits/method_limits/failing_shapes.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <numbers>

namespace springdrive::limits {
namespace {

struct Corners {
    Vector3 a;
    Vector3 b;
    Vector3 c;

    [[nodiscard]] Vector3 normal() const { return (b - a).cross(c - a).normalized(); }
};

Corners corners(const contact::TriangleSoup &soup, std::size_t triangle) {
    const auto &[a, b, c] = soup.triangles[triangle];
    return {soup.vertices_m[a], soup.vertices_m[b], soup.vertices_m[c]};
}

TEST(FailingShapes, FacesOfAPitStandAtItsAngle) {
    for (const int faces : {2, 3, 5}) {
        for (const double opening_deg : {1.0, 60.0, 120.0, 179.0}) {
            const double opening_rad = opening_deg * std::numbers::pi / 180.0;
            const contact::TriangleSoup soup = pit(faces, opening_rad);
            for (std::size_t i = 0; i < soup.triangles.size(); ++i) {
                const Corners t = corners(soup, i);
                // Facing into the pit, through its edge or corner.
                EXPECT_NEAR(t.normal().y(), std::sin(0.5 * opening_rad), 1e-9);
                EXPECT_NEAR(t.normal().dot(t.a), 0.0, 1e-12);
            }
        }
    }
}

TEST(FailingShapes, ACrackHasTheRequestedWidth) {
    const contact::TriangleSoup soup = cracked_sheet(1e-3);
    double nearest_m = HUGE_VAL;
    for (std::size_t i = 0; i < soup.triangles.size(); ++i) {
        EXPECT_NEAR(corners(soup, i).normal().y(), 1.0, 1e-12);
    }
    for (const Vector3 &vertex : soup.vertices_m) {
        EXPECT_EQ(vertex.y(), 0.0);
        nearest_m = std::min(nearest_m, std::abs(vertex.x()));
    }
    EXPECT_EQ(nearest_m, 0.5e-3);
}

} // namespace
} // namespace springdrive::limits
